// Parallel loops over independent ranges, and the thread pool that runs them.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include "collision/thread_pool/parker.h"

namespace cwm {

class ThreadPool;

// One thread of a pool.
struct Worker {
  int number = 0;  // 0 for the thread that owns the pool
  const class ParallelLoop* waiting_for =
      nullptr;  // until this loop ends, it runs only loops nested in it
  Parker parker;
};

// A parallel loop, on the stack of the thread that opened it. body(begin, end) is called for
// consecutive ranges of [0, count), which are handed out in order and run in any order.
// `range_size` is positive.
class ParallelLoop {
 public:
  using Body = std::function<void(std::size_t begin, std::size_t end)>;
  // `threads` returns how many threads may run at present. It is called before each range, on any
  // thread, so it must be cheap and thread safe. `threads` and `body` must outlive the loop.
  ParallelLoop(std::size_t count, std::size_t range_size, const std::function<int()>& threads,
               const Body& body);
  ParallelLoop(const ParallelLoop&) = delete;
  ParallelLoop& operator=(const ParallelLoop&) = delete;

  // Runs the loop on this thread and on those of its pool; returns when all ranges are done. A loop
  // within the body of another loop uses this thread and those for which the enclosing loops have
  // no more ranges, so that there are never more threads than the outermost loop allows. The first
  // exception of a body ends the loop and is rethrown. If the system cannot start threads, fewer do
  // the work.
  void Run();

 private:
  friend class ThreadPool;

  bool IsWithin(const ParallelLoop& other) const;
  int MaxThreads() const;
  // Runs ranges until none are left, or until the limit of threads excludes the given thread.
  void RunRanges(int thread);

  ParallelLoop* const enclosing_;  // the loop in whose body this one is; null if there is none
  const ParallelLoop& outermost_;
  const std::size_t count_;
  const std::size_t range_size_;
  const std::function<int()>& threads_;
  const Body& body_;
  std::atomic<std::size_t> next_{0};
  std::atomic<int> helpers_{0};  // threads that help to run it; written under the pool's mutex
  std::mutex failure_mutex_;
  std::exception_ptr first_failure_;
};

// A thread that opens loops, and its helpers, which live as long as it does, because starting a
// thread takes longer than most loops. A helper takes ranges of the outermost open loop that has
// some left. A thread that waits for the last ranges of its own loop takes ranges of loops nested
// in that one. A thread that finds no range stays awake for a moment, since the next loop often
// follows soon, and then sleeps.
class ThreadPool {
 public:
  // The pool of the loop in whose body the calling thread is, else the calling thread's own pool.
  static ThreadPool& Current();

  ~ThreadPool();
  ThreadPool() = default;
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  // Opens the loop to `helpers` threads, runs it on the calling thread too, and returns when all is
  // done.
  void Run(ParallelLoop& loop, int helpers);

 private:
  struct Helper {
    Worker worker;
    std::jthread thread;
  };

  static bool CanRun(const Worker& worker, const ParallelLoop& loop);
  void Open(ParallelLoop& loop, int helpers);
  bool StartHelper();  // false if the system cannot start a thread
  void Close(ParallelLoop& loop);
  ParallelLoop* Join(const Worker& worker);
  void Leave(ParallelLoop& loop);
  // Runs open loops until is_done returns true, which is checked after each change.
  template <class Done>
  void RunLoops(Worker& worker, const Done& is_done);
  void ParkUnlessChanged(Worker& worker, unsigned seen);

  std::mutex mutex_;
  Worker own_;
  std::vector<ParallelLoop*> open_;   // the outermost first
  std::vector<Worker*> parked_;       // threads asleep that nobody has woken yet
  std::atomic<unsigned> changes_{0};  // counts the loops opened and finished
  std::atomic<bool> is_stopping_{false};
  std::list<Helper> helpers_;
};

}  // namespace cwm
