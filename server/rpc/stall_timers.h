// Ends calls that make no progress: a reader that takes no more bytes, a sender that sends none.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

#include "server/core/limits.h"
#include "server/rpc/timer.h"

namespace cwm::server {

// Thread safe. Must outlive its guards. All guards together are checked once a second.
class StallTimers {
 public:
  explicit StallTimers(Timer& timer) : timer_(timer) {}

 private:
  struct Entry {
    Clock::time_point due;
    std::chrono::milliseconds limit;
    std::function<void()> end;
    bool is_ending = false;
    std::thread::id ending_thread = {};
  };
  using Entries = std::list<Entry>;

 public:
  // Calls its function once, from the timer's thread, if it exists for as long as the limit without
  // a restart. The destructor waits for a call of the function that is running in another thread.
  class Guard {
   public:
    Guard() = default;  // an inactive guard
    Guard(StallTimers& timers, std::chrono::milliseconds limit, std::function<void()> end);
    ~Guard();
    Guard(Guard&& other) noexcept;
    Guard& operator=(Guard&& other) noexcept;

    void Restart();

   private:
    StallTimers* timers_ = nullptr;
    Entries::iterator entry_;
  };

 private:
  void ScheduleCheck();
  void CheckStalls();

  Timer& timer_;
  std::mutex mutex_;
  std::condition_variable ended_;
  Entries entries_;
  bool check_scheduled_ = false;  // a check is scheduled or running
};

}  // namespace cwm::server
