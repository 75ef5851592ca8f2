// Household goods of random size, as solids in a pose of rest.
#pragma once

#include <string_view>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

enum class GoodKind { kCylinder, kSphere, kCup, kBox };
inline constexpr int kGoodKindCount = 4;

// How a thing rests. Lying: on its side, a cup along its generatrix. Leaning: on a bottom edge or a
// point of its rim, towards the object's x axis, with its weight beyond that edge, so that
// something has to hold it there.
enum class Rest { kStanding, kLying, kLeaning };

// One solid of the kind: cylinders of 15 to 60 mm radius and 4 to 25 cm length, spheres of 20 to 60
// mm, cups (truncated cones of 4 to 15 degrees half angle, 5 to 14 cm high) with the wide side up
// or down, boxes of 4 to 30 cm edges, small ones more often. The object's frame is z up with z = 0
// the support that it touches; X_WO is identity. A rest that makes no sense for the kind or the
// drawn size (a lying box, a leaning sphere, a cylinder flat like a coin on its rim, a slender one
// standing) becomes one that does.
SimulatedObject DrawGood(GoodKind kind, Rest rest, RandomDraws& draws);

// "cylinder", "sphere", "cup", "box".
std::string_view NameOf(GoodKind kind);

}  // namespace cwm::perception
