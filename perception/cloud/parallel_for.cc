#include "perception/cloud/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace cwm::perception {
namespace {

// One loop while it runs: its threads that have no more of its ranges to take, which loops within its
// bodies may have.
struct Loop {
  Loop* const around;  // of which this one is in a body; null for none
  std::atomic<int> free_threads{0};
};
thread_local Loop* around = nullptr;  // of which this thread runs a body

class InBodyOf {
 public:
  explicit InBodyOf(Loop& loop) { around = &loop; }
  ~InBodyOf() { around = before_; }
  InBodyOf(const InBodyOf&) = delete;
  InBodyOf& operator=(const InBodyOf&) = delete;

 private:
  Loop* const before_ = around;
};

// Free threads of the loops around, the innermost first, given back at the end.
class Claim {
 public:
  Claim(Loop* innermost, int most) {
    for (Loop* loop = innermost; loop != nullptr && count_ < most; loop = loop->around) {
      const int taken = TakeFrom(*loop, most - count_);
      if (taken > 0) taken_.emplace_back(loop, taken);
      count_ += taken;
    }
  }
  ~Claim() {
    for (const auto& [loop, count] : taken_) loop->free_threads += count;
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

  int count() const { return count_; }

 private:
  static int TakeFrom(Loop& loop, int most) {
    int free = loop.free_threads, taken = 0;
    do {
      taken = std::clamp(most, 0, free);
    } while (!loop.free_threads.compare_exchange_weak(free, free - taken));
    return taken;
  }

  std::vector<std::pair<Loop*, int>> taken_;
  int count_ = 0;
};

}  // namespace

void ParallelFor(std::size_t count, std::size_t range_size, const Work& work,
                 const std::function<void(std::size_t, std::size_t)>& body) {
  range_size = std::max<std::size_t>(range_size, 1);
  if (count <= range_size) {  // no loop: those within have the threads that it had
    work.Poll();
    if (count > 0) body(0, count);
    return;
  }
  const std::size_t ranges = (count + range_size - 1) / range_size;
  const int useful = static_cast<int>(std::min(ranges, static_cast<std::size_t>(work.Threads())));
  const Claim claimed(around, useful - 1);
  const int helpers = around ? claimed.count() : useful - 1;
  Loop loop{.around = around};
  std::atomic<std::size_t> next{0};
  std::exception_ptr first_failure;
  std::mutex failure_mutex;
  // Thread 0 is the caller's own, which never gives up.
  auto run = [&](int thread) {
    const InBodyOf guard(loop);
    try {
      while (thread < work.Threads()) {
        const std::size_t begin = next.fetch_add(range_size);
        if (begin >= count) {
          ++loop.free_threads;
          break;
        }
        work.Poll();
        body(begin, std::min(begin + range_size, count));
      }
    } catch (...) {
      next = count;  // the others stop early; the caller sees the exception
      std::lock_guard<std::mutex> lock(failure_mutex);
      if (!first_failure) first_failure = std::current_exception();
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 1; i <= helpers; ++i) threads.emplace_back(run, i);
  run(0);
  threads.clear();  // joins
  if (first_failure) std::rethrow_exception(first_failure);
}

void DoBoth(const Work& work, const std::function<void()>& first,
            const std::function<void()>& second) {
  ParallelFor(2, 1, work, [&](std::size_t begin, std::size_t) { begin == 0 ? first() : second(); });
}

}  // namespace cwm::perception
