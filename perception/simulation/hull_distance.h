// How far apart placed solids are, so that scenes made at random hold nothing that interpenetrates.
#pragma once

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// The distance between the convex hulls of two shapes placed in one frame, metres: never more than
// the true one, and less by at most a micrometre; 0 where the hulls overlap. No half-spaces.
double HullDistance_m(const Placed<>& a, const Placed<>& b);

// The least distance between the hulls of a part of `a` and a part of `b`, both in the world. What
// lies in the cavity of a vessel counts as inside it.
double Clearance_m(const SimulatedObject& a, const SimulatedObject& b);

// Moves `object` along the unit vector `direction_W` until it touches `obstacle`: at most 0.1 mm
// away, never inside. False, and the object unchanged, when it misses the obstacle or overlaps it
// from the start.
bool SlideUntilTouching(const Vector3& direction_W, const SimulatedObject& obstacle,
                        SimulatedObject& object);

}  // namespace cwm::perception
