// Lets a caller count the steps of a long computation and end it.
#pragma once

#include <cstddef>

namespace cwm {

// Lent to a computation; only the thread of that computation uses it.
class WorkCounter {
 public:
  virtual ~WorkCounter() = default;

  // Counts steps of some tens of nanoseconds each, such as a box compared or four corners
  // evaluated. True if the computation must end; its result is then void. With 0 steps it only says
  // whether the computation had to end before.
  virtual bool MustEndAfter(std::size_t steps) = 0;
  // The same, but always reads the clock, whatever the count: for threads that wait.
  virtual bool MustEndNow() = 0;
};

// False without a counter.
inline bool MustEnd(WorkCounter* work, std::size_t steps) {
  return work != nullptr && work->MustEndAfter(steps);
}
inline bool HasEnded(WorkCounter* work) { return MustEnd(work, 0); }

// Calls do_range(first, last) for consecutive ranges of [0, count), each of which takes some tens
// of microseconds if one element takes `steps`. False if `work` ended it early.
template <class DoRange>
bool ForEachBlock(std::size_t count, WorkCounter* work, const DoRange& do_range,
                  std::size_t steps = 1) {
  constexpr std::size_t kStepsPerBlock = std::size_t{1} << 12;
  const std::size_t block_size = steps < kStepsPerBlock ? kStepsPerBlock / steps : 1;
  for (std::size_t first = 0; first < count;) {
    const std::size_t last = count - first < block_size ? count : first + block_size;
    do_range(first, last);
    if (MustEnd(work, (last - first) * steps)) return false;
    first = last;
  }
  return !HasEnded(work);
}

}  // namespace cwm
