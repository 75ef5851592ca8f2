// Ends what stands still: a reader that takes no more bytes, a sender that sends none.
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

// Thread safe; outlives its guards. One look a second at all guards, whatever their number.
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
  // While it lives and is not restarted for as long as the limit, its function is called once, from
  // the timer's thread. Its destructor waits for a call of the function under way in another
  // thread.
  class Guard {
   public:
    Guard() = default;  // guards nothing
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
  void LookSoon();
  void Look();

  Timer& timer_;
  std::mutex mutex_;
  std::condition_variable ended_;
  Entries entries_;
  bool is_looking_ = false;  // a look is due or under way
};

}  // namespace cwm::server
