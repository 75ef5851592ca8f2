#include "server/core/live/live_worlds.h"

#include <utility>
#include <vector>

#include "server/core/world_feed.h"

namespace cwm::server {

std::shared_ptr<LiveWorld> LiveWorlds::Of(const std::shared_ptr<World>& world) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<LiveWorld>& live = worlds_[world->uid()];
  if (live == nullptr) live = std::make_shared<LiveWorld>(world, services_);
  return live;
}

std::shared_ptr<LiveWorld> LiveWorlds::Find(const std::string& world_uid) const {
  const std::lock_guard lock(mutex_);
  const auto found = worlds_.find(world_uid);
  return found == worlds_.end() ? nullptr : found->second;
}

void LiveWorlds::Forget(const World& world) {
  std::shared_ptr<LiveWorld> live;
  {
    const std::lock_guard lock(mutex_);
    const auto found = worlds_.find(world.uid());
    if (found == worlds_.end()) return;
    live = std::move(found->second);
    worlds_.erase(found);
  }
  live->End(WorldDeleted());
}

bool LiveWorlds::ForgetGone(Clock::time_point now) {
  std::vector<std::shared_ptr<LiveWorld>> worlds;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [uid, live] : worlds_) worlds.push_back(live);
  }
  bool is_freed = false;
  for (const std::shared_ptr<LiveWorld>& live : worlds) is_freed |= live->ForgetGone(now);
  return is_freed;
}

}  // namespace cwm::server
