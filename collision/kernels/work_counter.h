// What a search that may take long tells of its work to who asked, who may want it to end.
#pragma once

#include <cstddef>

namespace cwm::collision {

// Lent to a search; used by its thread alone.
class WorkCounter {
 public:
  virtual ~WorkCounter() = default;

  // Counts steps of some tens of nanoseconds each: a box compared, four corners looked at. True when
  // the search must end: whatever it answers then is void.
  virtual bool MustEndAfter(std::size_t steps) = 0;
};

// Steps of asking two convex solids of few corners, be they triangles.
inline constexpr std::size_t kStepsOfConvexPair = 16;

// Of telling whether a mesh encloses a point: a ray through its tree.
inline constexpr std::size_t kStepsOfEnclosing = 64;

// Without a counter nothing ends.
inline bool MustEnd(WorkCounter* work, std::size_t steps) {
  return work != nullptr && work->MustEndAfter(steps);
}

}  // namespace cwm::collision
