#include "perception/cloud/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cwm::perception {
namespace {

thread_local bool in_body = false;  // this thread runs the body of some loop

class InBody {
 public:
  InBody() { in_body = true; }
  ~InBody() { in_body = before_; }
  InBody(const InBody&) = delete;
  InBody& operator=(const InBody&) = delete;

 private:
  const bool before_ = in_body;
};

}  // namespace

void ParallelFor(std::size_t count, std::size_t range_size, const Work& work,
                 const std::function<void(std::size_t, std::size_t)>& body) {
  range_size = std::max<std::size_t>(range_size, 1);
  const int most_threads = in_body ? 1 : work.Threads();
  std::atomic<std::size_t> next{0};
  std::exception_ptr first_failure;
  std::mutex failure_mutex;
  // Thread 0 is the caller's own, which never gives up.
  auto run = [&](int thread) {
    const InBody guard;
    try {
      while (thread < work.Threads()) {
        const std::size_t begin = next.fetch_add(range_size);
        if (begin >= count) break;
        work.Poll();
        body(begin, std::min(begin + range_size, count));
      }
    } catch (...) {
      next = count;  // the others stop early; the caller sees the exception
      std::lock_guard<std::mutex> lock(failure_mutex);
      if (!first_failure) first_failure = std::current_exception();
    }
  };
  const std::size_t ranges = (count + range_size - 1) / range_size;
  const int helpers =
      static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(most_threads), ranges));
  std::vector<std::jthread> threads;
  for (int i = 1; i < helpers; ++i) threads.emplace_back(run, i);
  run(0);
  threads.clear();  // joins
  if (first_failure) std::rethrow_exception(first_failure);
}

void DoBoth(const Work& work, const std::function<void()>& first,
            const std::function<void()>& second) {
  ParallelFor(2, 1, work, [&](std::size_t begin, std::size_t) { begin == 0 ? first() : second(); });
}

}  // namespace cwm::perception
