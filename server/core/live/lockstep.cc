#include "server/core/live/lockstep.h"

#include <utility>

namespace cwm::server {

void Lockstep::Begin(Callback begin) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(begin));
  }
  Advance();
}

void Lockstep::End(Callback end) {
  {
    const std::lock_guard lock(mutex_);
    end_ = std::move(end);
  }
  Advance();
}

Lockstep::Token Lockstep::RunBeside() {
  const std::lock_guard lock(mutex_);
  ++running_;
  return {this, [](Lockstep* lockstep) { lockstep->Leave(); }};
}

void Lockstep::Leave() {
  {
    const std::lock_guard lock(mutex_);
    --running_;
  }
  Advance();
}

void Lockstep::Advance() {
  for (;;) {
    Callback callback;
    bool ends = false;
    {
      const std::lock_guard lock(mutex_);
      if (running_ > 0) return;
      if (end_) {
        callback = std::exchange(end_, {});
        ends = true;
      } else if (!is_taken_ && !waiting_.empty()) {
        callback = std::move(waiting_.front());
        waiting_.pop_front();
        is_taken_ = true;
      } else {
        return;
      }
    }
    callback();
    if (!ends) continue;
    const std::lock_guard lock(mutex_);
    is_taken_ = false;
  }
}

}  // namespace cwm::server
