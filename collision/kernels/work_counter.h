// The cost of the kernels' steps, as counted by a WorkCounter.
#pragma once

#include <cstddef>

#include "collision/geometry/work_counter.h"

namespace cwm::collision {

// Steps of testing two convex solids of few corners, such as triangles.
inline constexpr std::size_t kStepsPerConvexPair = 16;

// Steps of testing whether a mesh encloses a point: one ray through its tree.
inline constexpr std::size_t kStepsPerContainmentTest = 64;

}  // namespace cwm::collision
