#include "server/rpc/stall_timers.h"

#include <utility>

namespace cwm::server {
namespace {

constexpr auto kCheckPeriod = std::chrono::seconds(1);

}  // namespace

StallTimers::Guard::Guard(StallTimers& timers, std::chrono::milliseconds limit,
                          std::function<void()> end)
    : timers_(&timers) {
  const std::lock_guard lock(timers.mutex_);
  timers.entries_.push_back({.due = Clock::now() + limit, .limit = limit, .end = std::move(end)});
  entry_ = std::prev(timers.entries_.end());
  if (!std::exchange(timers.check_scheduled_, true)) timers.ScheduleCheck();
}

StallTimers::Guard::~Guard() {
  if (timers_ == nullptr) return;
  std::unique_lock lock(timers_->mutex_);
  timers_->ended_.wait(lock, [this] {
    return !entry_->is_ending || entry_->ending_thread == std::this_thread::get_id();
  });
  timers_->entries_.erase(entry_);
}

StallTimers::Guard::Guard(Guard&& other) noexcept
    : timers_(std::exchange(other.timers_, nullptr)), entry_(other.entry_) {}

StallTimers::Guard& StallTimers::Guard::operator=(Guard&& other) noexcept {
  std::swap(timers_, other.timers_);
  std::swap(entry_, other.entry_);
  return *this;
}

void StallTimers::Guard::Restart() {
  if (timers_ == nullptr) return;
  const std::lock_guard lock(timers_->mutex_);
  entry_->due = Clock::now() + entry_->limit;
}

void StallTimers::ScheduleCheck() {
  timer_.After(kCheckPeriod, [this] { CheckStalls(); });
}

void StallTimers::CheckStalls() {
  std::unique_lock lock(mutex_);
  const auto now = Clock::now();
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (entry->due > now || !entry->end) {
      ++entry;
      continue;
    }
    entry->is_ending = true;
    entry->ending_thread = std::this_thread::get_id();
    const std::function<void()> end = std::exchange(entry->end, nullptr);
    lock.unlock();
    end();  // the guard may be gone afterwards
    lock.lock();
    // The list may have changed anywhere meanwhile.
    for (Entry& ended : entries_) ended.is_ending = false;
    ended_.notify_all();
    entry = entries_.begin();
  }
  check_scheduled_ = !entries_.empty();
  if (check_scheduled_) ScheduleCheck();
}

}  // namespace cwm::server
