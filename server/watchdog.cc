#include "server/watchdog.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <string>
#include <utility>

namespace cwm::server {

Watchdog::Watchdog(std::chrono::milliseconds period,
                   std::function<absl::Status(std::chrono::milliseconds)> check,
                   std::function<void()> notify)
    : period_(period),
      check_(std::move(check)),
      notify_(std::move(notify)),
      thread_([this] { Run(); }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Watchdog::Run() {
  pthread_setname_np(pthread_self(), "watchdog");
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto next = std::chrono::steady_clock::now() + period_;
    lock.unlock();
    const absl::Status status = check_(period_);
    if (status.ok()) notify_();
    lock.lock();
    if (!status.ok() && !stopping_) {
      spdlog::error("the server does not answer itself: {}", std::string(status.message()));
    }
    changed_.wait_until(lock, next, [this] { return stopping_; });
  }
}

}  // namespace cwm::server
