// What steps of the kernels weigh for a WorkCounter.
#pragma once

#include <cstddef>

#include "collision/geometry/work_counter.h"

namespace cwm::collision {

// Steps of asking two convex solids of few corners, be they triangles.
inline constexpr std::size_t kStepsOfConvexPair = 16;

// Of telling whether a mesh encloses a point: a ray through its tree.
inline constexpr std::size_t kStepsOfEnclosing = 64;

}  // namespace cwm::collision
