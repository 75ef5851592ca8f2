// What work that may take long tells of itself to who asked for it, who may want it to end.
#pragma once

#include <cstddef>

namespace cwm {

// Lent to a computation; used by its thread alone.
class WorkCounter {
 public:
  virtual ~WorkCounter() = default;

  // Counts steps of some tens of nanoseconds each: a box compared, four corners looked at. True when
  // the computation must end: whatever it answers then is void. With 0 steps it tells whether it had
  // to end before.
  virtual bool MustEndAfter(std::size_t steps) = 0;
  // The same, after a look at the time that is not left to the count: for who waits.
  virtual bool MustEndNow() = 0;
};

// Without a counter nothing ends.
inline bool MustEnd(WorkCounter* work, std::size_t steps) {
  return work != nullptr && work->MustEndAfter(steps);
}
inline bool HasEnded(WorkCounter* work) { return MustEnd(work, 0); }

// Calls do_range(first, last) for [0, count) in ranges that take some tens of microseconds each
// where an element takes `steps`. False where `work` ended it before.
template <class DoRange>
bool InPieces(std::size_t count, WorkCounter* work, const DoRange& do_range,
              std::size_t steps = 1) {
  constexpr std::size_t kStepsOfPiece = std::size_t{1} << 12;
  const std::size_t most = steps < kStepsOfPiece ? kStepsOfPiece / steps : 1;
  for (std::size_t first = 0; first < count;) {
    const std::size_t last = count - first < most ? count : first + most;
    do_range(first, last);
    if (MustEnd(work, (last - first) * steps)) return false;
    first = last;
  }
  return !HasEnded(work);
}

}  // namespace cwm
