// Things to do later: idle bookmarks, time budgets, waits for a revision.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

namespace cwm::server {

// Thread safe. One thread runs what is due, in order; the functions must be short (they enqueue).
class Timer {
 public:
  Timer();
  ~Timer();  // stops
  // What is not due yet is dropped, and so is all that comes later. Waits for the task under way.
  void Stop();

  void After(std::chrono::steady_clock::duration delay, std::function<void()> task);

 private:
  void Run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::multimap<std::chrono::steady_clock::time_point, std::function<void()>> due_;
  bool stopping_ = false;
  std::thread thread_;  // last: starts when the rest is there
};

}  // namespace cwm::server
