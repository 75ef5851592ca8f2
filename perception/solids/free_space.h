// Tests whether a solid fills space that rays were seen to cross.
#pragma once

#include "perception/cloud/sensor_noise.h"
#include "perception/fit/passing_rays.h"
#include "perception/fit/solid.h"

namespace cwm::perception {

// derived: a ray that runs deeper than this in a solid contradicts it, because such points are not
// explained by the solid.
inline constexpr double kMaxDepth_m = kExplainedWithin_m;

// Counts the points that were measured through the solid: their ray, or they themselves, lie more
// than kMaxDepth_m (or 3 sigma, or in a thin solid a third of its thickness) inside.
struct Contradiction {
  std::size_t rays = 0;      // rays that contradict the solid
  std::size_t examined = 0;  // rays that were examined
};
Contradiction FindContradiction(const Solid& solid, const ModelPoints& points);

// True if the segment enters the solid by more than the unevenness of a surface (1 mm). A wall
// thinner than twice that is never entered.
bool EntersSolid(const Solid& solid, const Vector3& begin, const Vector3& end);

// The share of the rays that passed the object and enter the solid; 0 if there are no rays.
double CrossingRayShare(const Solid& solid, const FreeRays& free);

// The number of measured rays that passed the object but run deeper than kMaxDepth_m in the solid.
double DeepRayCount(const Solid& solid, const FreeRays& free);

// True if these rays are more than noise and mixed pixels explain, for a solid of `points` measured
// points. For an object that hangs high they are a small share of the rays beside it, but as many
// as its points.
bool IsPassedThrough(const Solid& solid, double points, const FreeRays& free);

}  // namespace cwm::perception
