// Loops over independent pieces of work, and the threads that run them.
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

// One thread of a crew.
struct CrewMember {
  int number = 0;                         // 0: the thread whose crew it is
  const class Loop* waits_for = nullptr;  // a loop of its own, whose inner loops alone it may run
  Sleeper sleeper;
};

// One loop while it runs, on the stack of the thread that opened it: body(begin, end) for consecutive
// ranges of [0, count), which are handed out in order and run in any order. `range_size` is positive.
class Loop {
 public:
  using Body = std::function<void(std::size_t begin, std::size_t end)>;
  // `threads` tells how many may run just now, asked before each range: cheap, and safe on all threads
  // at once. Both must outlive the loop.
  Loop(std::size_t count, std::size_t range_size, const std::function<int()>& threads,
       const Body& body);
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  // On this thread and on those of its crew; returns when all is done. Within the body of another loop:
  // on this thread and on those that the loops around have no more ranges for, so that there are never
  // more threads than the outermost loop was given. The first exception of a body ends the loop and
  // is rethrown. Where the system has no threads to give, fewer do the work.
  void Do();

 private:
  friend class Crew;

  bool IsWithin(const Loop& other) const;
  int MostThreads() const;
  // Takes ranges until there are none, or until the thread of that number should not run any more.
  void Run(int thread);

  Loop* const around_;  // of which this one is in a body; null for none
  const Loop& outermost_;
  const std::size_t count_;
  const std::size_t range_size_;
  const std::function<int()>& threads_;
  const Body& body_;
  std::atomic<std::size_t> next_{0};
  std::atomic<int> helpers_{0};  // that run ranges of it; written under the crew's mutex
  std::mutex failure_mutex_;
  std::exception_ptr first_failure_;
};

// A thread that opens loops and its helpers, which live as long as it does, for to start a thread
// takes longer than most loops. They take ranges of the loops that are open, of the outermost one
// that has some, and so does a thread that waits for the last ranges of its loop, of loops within.
// Who finds none stays awake for a moment, since the next loop is often near, then sleeps.
class Crew {
 public:
  // That of the loop in whose body the calling thread is, else the calling thread's own.
  static Crew& OfThisThread();

  ~Crew();
  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  // Opens the loop to so many helpers, runs it on the calling thread, and returns when all is done.
  void Do(Loop& loop, int helpers);

 private:
  struct Helper {
    CrewMember member;
    std::jthread thread;
  };

  static bool MayRun(const CrewMember& member, const Loop& loop);
  void Open(Loop& loop, int helpers);
  bool StartHelper();  // false where the system has none
  void Close(Loop& loop);
  Loop* Join(const CrewMember& member);
  void Leave(Loop& loop);
  // Runs what is open until is_done, asked after each change.
  template <class Done>
  void Serve(CrewMember& member, const Done& is_done);
  void SleepUnlessChanged(CrewMember& member, unsigned seen);

  std::mutex mutex_;
  CrewMember own_;
  std::vector<Loop*> open_;            // the outermost first
  std::vector<CrewMember*> sleeping_;  // whom nobody woke yet
  std::atomic<unsigned> changes_{0};   // loops opened and finished
  std::atomic<bool> is_ending_{false};
  std::list<Helper> helpers_;
};

}  // namespace cwm
