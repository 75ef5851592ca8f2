#include "server/rpc/open_calls.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace cwm::server {
namespace {

// chosen: the period at which WaitUntilNone polls is_busy.
constexpr auto kBusyPollPeriod = std::chrono::milliseconds(10);

}  // namespace

OpenCalls::Token::Token(OpenCalls& calls, std::stop_source stop)
    : calls_(calls), stop_(std::move(stop)) {
  const std::lock_guard lock(calls_.mutex_);
  position_ = calls_.open_.insert(calls_.open_.end(), this);
  is_late_ = calls_.is_draining_;
  if (is_late_) ++calls_.late_;
  if (calls_.stop_requested_) stop_.request_stop();
}

OpenCalls::Token::~Token() {
  // Notified under the lock, since the waiting thread may destroy the list as soon as it is
  // released.
  const std::lock_guard lock(calls_.mutex_);
  calls_.open_.erase(position_);
  if (is_late_) {
    --calls_.late_;
    return;
  }
  calls_.last_progress_ = Clock::now();
  if (calls_.IsEmpty()) calls_.none_.notify_all();
}

void OpenCalls::SetDraining() {
  const std::lock_guard lock(mutex_);
  is_draining_ = true;
}

void OpenCalls::NoteProgress() {
  const std::lock_guard lock(mutex_);
  last_progress_ = Clock::now();
}

void OpenCalls::RequestStop() {
  std::vector<std::stop_source> stops;
  {
    const std::lock_guard lock(mutex_);
    stop_requested_ = true;
    for (const Token* const token : open_) stops.push_back(token->stop_);
  }
  // Without the lock, since a stop callback may end its call right away.
  for (std::stop_source& stop : stops) stop.request_stop();
}

bool OpenCalls::stop_requested() const {
  const std::lock_guard lock(mutex_);
  return stop_requested_;
}

bool OpenCalls::WaitUntilNone(Clock::time_point end, Clock::duration patience,
                              const std::function<bool()>& is_busy) {
  std::unique_lock lock(mutex_);
  auto quiet_since = Clock::now();
  for (;;) {
    if (IsEmpty()) return true;
    const auto now = Clock::now();
    if (is_busy()) quiet_since = now;
    quiet_since = std::max(quiet_since, last_progress_);
    if (now >= end || now - quiet_since >= patience) return false;
    none_.wait_until(lock, std::min(end, now + kBusyPollPeriod));
  }
}

}  // namespace cwm::server
