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

#include "collision/crew/sleeper.h"

namespace cwm {

class Crew;

// One thread of a pool.
struct CrewMember {
  int number = 0;                         // 0 for the thread that owns the pool
  const class Loop* waits_for = nullptr;  // until this loop ends, it runs only loops nested in it
  Sleeper sleeper;
};

// A parallel loop, on the stack of the thread that opened it. body(begin, end) is called for
// consecutive ranges of [0, count), which are handed out in order and run in any order.
// `range_size` is positive.
class Loop {
 public:
  using Body = std::function<void(std::size_t begin, std::size_t end)>;
  // `threads` returns how many threads may run at present. It is called before each range, on any
  // thread, so it must be cheap and thread safe. `threads` and `body` must outlive the loop.
  Loop(std::size_t count, std::size_t range_size, const std::function<int()>& threads,
       const Body& body);
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  // Runs the loop on this thread and on those of its pool; returns when all ranges are done. A loop
  // within the body of another loop uses this thread and those for which the enclosing loops have
  // no more ranges, so that there are never more threads than the outermost loop allows. The first
  // exception of a body ends the loop and is rethrown. If the system cannot start threads, fewer do
  // the work.
  void Do();

 private:
  friend class Crew;

  bool IsWithin(const Loop& other) const;
  int MostThreads() const;
  // Runs ranges until none are left, or until the limit of threads excludes the given thread.
  void Run(int thread);

  Loop* const around_;  // the loop in whose body this one is; null if there is none
  const Loop& outermost_;
  const std::size_t count_;
  const std::size_t range_size_;
  const std::function<int()>& threads_;
  const Body& body_;
  std::atomic<std::size_t> next_{0};
  std::atomic<int> helpers_{0};  // threads that help to run it; written under the crew's mutex
  std::mutex failure_mutex_;
  std::exception_ptr first_failure_;
};

// A thread that opens loops, and its helpers, which live as long as it does, because starting a
// thread takes longer than most loops. A helper takes ranges of the outermost open loop that has
// some left. A thread that waits for the last ranges of its own loop takes ranges of loops nested
// in that one. A thread that finds no range stays awake for a moment, since the next loop often
// follows soon, and then sleeps.
class Crew {
 public:
  // The pool of the loop in whose body the calling thread is, else the calling thread's own pool.
  static Crew& OfThisThread();

  ~Crew();
  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  // Opens the loop to `helpers` threads, runs it on the calling thread too, and returns when all is
  // done.
  void Do(Loop& loop, int helpers);

 private:
  struct Helper {
    CrewMember member;
    std::jthread thread;
  };

  static bool MayRun(const CrewMember& member, const Loop& loop);
  void Open(Loop& loop, int helpers);
  bool StartHelper();  // false if the system cannot start a thread
  void Close(Loop& loop);
  Loop* Join(const CrewMember& member);
  void Leave(Loop& loop);
  // Runs open loops until is_done returns true, which is checked after each change.
  template <class Done>
  void Serve(CrewMember& member, const Done& is_done);
  void SleepUnlessChanged(CrewMember& member, unsigned seen);

  std::mutex mutex_;
  CrewMember own_;
  std::vector<Loop*> open_;            // the outermost first
  std::vector<CrewMember*> sleeping_;  // threads asleep that nobody has woken yet
  std::atomic<unsigned> changes_{0};   // counts the loops opened and finished
  std::atomic<bool> is_ending_{false};
  std::list<Helper> helpers_;
};

}  // namespace cwm
