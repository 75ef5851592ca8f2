// Distances of placed solids, so that objects in random scenes do not interpenetrate.
#pragma once

#include "perception/simulation/simulated_scene.h"

namespace cwm::perception {

// The distance between the convex hulls of two shapes in one frame, in metres: never more than the
// true one, and at most a micrometre less; 0 if the hulls overlap. Not for half-spaces.
double HullDistance_m(const Placed<>& a, const Placed<>& b);

// The least distance between the hulls of a part of `a` and a part of `b`, both in the world. An
// object in the cavity of a vessel counts as inside it.
double Clearance_m(const SimulatedObject& a, const SimulatedObject& b);

// Moves `object` along the unit vector `direction_W` until it touches `obstacle`: at most 0.1 mm
// away, never inside. Returns false, with the object unchanged, if it misses the obstacle or
// overlaps it at the start.
bool SlideUntilTouching(const Vector3& direction_W, const SimulatedObject& obstacle,
                        SimulatedObject& object);

}  // namespace cwm::perception
