// Notifies the service manager periodically for as long as the server answers.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "absl/status/status.h"

namespace cwm::server {

// Runs one thread. A listener that has died looks healthy from within the process; only `check`,
// which connects like a client, notices.
class Watchdog {
 public:
  // Calls `check` once per period, with the period as its timeout, and calls `notify` whenever the
  // check succeeds. A failed check is logged.
  Watchdog(std::chrono::milliseconds period,
           std::function<absl::Status(std::chrono::milliseconds timeout)> check,
           std::function<void()> notify);
  ~Watchdog();  // waits for a check in progress
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  void Run();

  const std::chrono::milliseconds period_;
  const std::function<absl::Status(std::chrono::milliseconds)> check_;
  const std::function<void()> notify_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::thread thread_;  // last: starts when the other members exist
};

}  // namespace cwm::server
