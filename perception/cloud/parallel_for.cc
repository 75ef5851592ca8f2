#include "perception/cloud/parallel_for.h"

#include <algorithm>

#include "collision/thread_pool/thread_pool.h"

namespace cwm::perception {

void ParallelFor(std::size_t count, std::size_t range_size, const Work& work,
                 const std::function<void(std::size_t, std::size_t)>& body) {
  range_size = std::max<std::size_t>(range_size, 1);
  const auto polled = [&](std::size_t begin, std::size_t end) {
    work.Poll();
    body(begin, end);
  };
  if (count > range_size) {
    ParallelLoop(
        count, range_size, [&] { return work.Threads(); }, polled)
        .Run();
  } else if (count > 0) {
    polled(0, count);  // no loop here, so nested loops get its threads
  } else {
    work.Poll();
  }
}

void ParallelInvoke(const Work& work, const std::function<void()>& first,
                    const std::function<void()>& second) {
  ParallelFor(2, 1, work, [&](std::size_t begin, std::size_t) { begin == 0 ? first() : second(); });
}

}  // namespace cwm::perception
