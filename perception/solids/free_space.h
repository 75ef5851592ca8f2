// Whether a solid fills space that rays were seen to cross.
#pragma once

#include "perception/cloud/sensor_noise.h"
#include "perception/fit/passing_rays.h"
#include "perception/fit/solid.h"

namespace cwm::perception {

// derived: rays that run deeper than this in a solid contradict it, for what they met is more than
// the solid explains.
inline constexpr double kMaxDepth_m = kExplainedWithin_m;

// Of the points, how many were measured through the solid: their ray, or they themselves, lie more
// than kMaxDepth_m (or 3 sigma) inside.
struct Contradiction {
  std::size_t rays = 0;    // that contradict
  std::size_t looked = 0;  // at
};
Contradiction FindContradiction(const Solid& solid, const ModelPoints& points);

// Whether the way from one place to another enters the solid, by more than the noise of a surface:
// a wall is asked for whose thickness is twice that, 2 mm, or more.
bool Enters(const Solid& solid, const Vector3& begin, const Vector3& end);

// Of the rays that passed the object by, the share that enters the solid; 0 of none.
double PassedShare(const Solid& solid, const FreeRays& free);

// How many measured rays that passed the object by ran deeper than kMaxDepth_m in the solid.
double PassedDeep(const Solid& solid, const FreeRays& free);

// Whether these are more than noise and mixed pixels account for, of a solid of so many measured
// points. Of a thing that hangs high they are few of the rays beside it, but as many as its points.
bool IsPassedThrough(const Solid& solid, double points, const FreeRays& free);

}  // namespace cwm::perception
