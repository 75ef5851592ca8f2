#include "perception/cloud/parallel_for.h"

#include <algorithm>

#include "perception/cloud/crew.h"

namespace cwm::perception {

void ParallelFor(std::size_t count, std::size_t range_size, const Work& work,
                 const std::function<void(std::size_t, std::size_t)>& body) {
  range_size = std::max<std::size_t>(range_size, 1);
  if (count > range_size) {
    Loop(count, range_size, work, body).Do();
    return;
  }
  work.Poll();  // no loop: those within have the threads that it had
  if (count > 0) body(0, count);
}

void DoBoth(const Work& work, const std::function<void()>& first,
            const std::function<void()>& second) {
  ParallelFor(2, 1, work, [&](std::size_t begin, std::size_t) { begin == 0 ? first() : second(); });
}

}  // namespace cwm::perception
