// Tells the service manager again and again that the server answers, as long as it does.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "absl/status/status.h"

namespace cwm::server {

// One thread. A listener that has died looks well from within: only `check`, which goes through the
// front door, finds it.
class Watchdog {
 public:
  // Calls `check` once a period, which is also the time that it may take, and `tell` each time that
  // it is OK. What it finds otherwise is logged.
  Watchdog(std::chrono::milliseconds period,
           std::function<absl::Status(std::chrono::milliseconds timeout)> check,
           std::function<void()> tell);
  ~Watchdog();  // waits for a check under way
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  void Run();

  const std::chrono::milliseconds period_;
  const std::function<absl::Status(std::chrono::milliseconds)> check_;
  const std::function<void()> tell_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::thread thread_;  // last: starts when the rest is there
};

}  // namespace cwm::server
