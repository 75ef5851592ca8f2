#include "server/core/rule_expiry.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/core/world.h"

namespace cwm::server {
namespace {

// The delay before the next try after an expiry failed, e.g. for lack of memory or of room on the
// disk.
constexpr auto kRetryAfter = std::chrono::milliseconds(100);

bool TryExpireRules(World& world, Clock::time_point now) {
  try {
    return world.ExpireRules(now).ok();
  } catch (...) {  // an error of one world must not end the server
    return false;
  }
}

}  // namespace

RuleExpiry::RuleExpiry(Now now) : now_(std::move(now)), thread_([this] { Run(); }) {}

RuleExpiry::~RuleExpiry() { Stop(); }

void RuleExpiry::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void RuleExpiry::Set(const std::string& uid, std::weak_ptr<World> world,
                     std::optional<Clock::time_point> when) {
  {
    const std::lock_guard lock(mutex_);
    if (when.has_value()) {
      due_[uid] = {*when, std::move(world)};
    } else {
      due_.erase(uid);
    }
  }
  changed_.notify_all();
}

void RuleExpiry::Run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto first = std::min_element(due_.begin(), due_.end(), [](const auto& a, const auto& b) {
      return a.second.when < b.second.when;
    });
    if (first == due_.end()) {
      changed_.wait(lock);
      continue;
    }
    const Clock::time_point now = now_();
    if (now < first->second.when) {
      changed_.wait_for(lock, first->second.when - now);
      continue;
    }
    std::shared_ptr<World> world = first->second.world.lock();
    due_.erase(first);
    lock.unlock();
    if (world != nullptr && !TryExpireRules(*world, now))
      Set(world->uid(), world, now + kRetryAfter);
    world.reset();  // this may be the last reference, and freeing a world is slow
    lock.lock();
  }
}

}  // namespace cwm::server
