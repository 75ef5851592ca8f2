// The worlds of a server that sensors stream into.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/core/live/live_world.h"

namespace cwm::server {

// Thread safe.
class LiveWorlds {
 public:
  explicit LiveWorlds(LiveServices services) : services_(std::move(services)) {}

  // The live side of the world, made when it is first asked for. It stays until the world is
  // deleted.
  std::shared_ptr<LiveWorld> Of(const std::shared_ptr<World>& world);
  // nullptr: no sensor has streamed into the world.
  std::shared_ptr<LiveWorld> Find(const std::string& world_uid) const;

  // The world was deleted: its streams end with NOT_FOUND WORLD_DELETED.
  void Forget(const World& world);
  // As LiveWorld::ForgetGone, for all worlds.
  bool ForgetGone(Clock::time_point now);

 private:
  const LiveServices services_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<LiveWorld>> worlds_;  // by uid
};

}  // namespace cwm::server
