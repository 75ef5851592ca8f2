// Runs functions later: idle bookmarks, time budgets, waits for a revision.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

namespace cwm::server {

// Thread safe. One thread runs the due functions in order; they must be short (e.g. push to a
// queue).
class Timer {
 public:
  Timer();
  ~Timer();  // stops
  // Drops all pending and later functions. Waits for the running one.
  void Stop();

  void After(std::chrono::steady_clock::duration delay, std::function<void()> task);

 private:
  void Run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::multimap<std::chrono::steady_clock::time_point, std::function<void()>> due_;
  bool stopping_ = false;
  std::thread thread_;  // last: starts when the other members exist
};

}  // namespace cwm::server
