// The threads that run loops, see parallel_for.h.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include "perception/cloud/sleeper.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

class Crew;

// One thread of a crew.
struct CrewMember {
  int number = 0;                         // 0: the thread whose crew it is
  const class Loop* waits_for = nullptr;  // a loop of its own, whose inner loops alone it may run
  Sleeper sleeper;
};

// One loop while it runs, on the stack of the thread that opened it.
class Loop {
 public:
  Loop(std::size_t count, std::size_t range_size, const Work& work,
       const std::function<void(std::size_t, std::size_t)>& body);
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  // On this thread and on those of its crew; returns when all is done.
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
  const Work& work_;
  const std::function<void(std::size_t, std::size_t)>& body_;
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

}  // namespace cwm::perception
