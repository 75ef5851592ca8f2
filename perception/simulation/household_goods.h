// Household goods of random size, as solids in a pose of rest.
#pragma once

#include <string_view>

#include "perception/simulation/random_draws.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

enum class GoodsKind { kCylinder, kSphere, kCup, kBox };
inline constexpr int kGoodsKindCount = 4;

// The pose of rest. Lying: on its side, a cup along its generatrix. Leaning: on a bottom edge or a
// point of its rim, towards the object's x axis, with its weight beyond that edge, so that another
// object has to hold it.
enum class RestPose { kStanding, kLying, kLeaning };

// Draws one solid of the kind: cylinders of 15 to 60 mm radius and 4 to 25 cm length, spheres of 20
// to 60 mm radius, cups (truncated cones of 4 to 15 degrees half angle, 5 to 14 cm high) with the
// wide side up or down, boxes with edges of 4 to 30 cm, small ones more often. The object's frame
// is z up with z = 0 on its support; X_WO is the identity. A rest that is not possible for the kind
// or the drawn size (a lying box, a leaning sphere, a coin-like cylinder on its rim, a slender one
// standing) is replaced by one that is.
SimulatedObject DrawGoods(GoodsKind kind, RestPose rest, RandomDraws& draws);

// Returns "cylinder", "sphere", "cup" or "box".
std::string_view NameOf(GoodsKind kind);

}  // namespace cwm::perception
