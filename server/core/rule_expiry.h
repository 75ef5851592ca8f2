// Has worlds end what they allow pairs for a time, when that is over on the steady clock.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "server/core/limits.h"

namespace cwm::server {

class World;

// Thread safe. One thread waits for the first expiry of all worlds; it takes the world's turn to
// publish the end of it, so writers are waited for, never readers. Refers to worlds weakly: what is
// due in a world that is gone is forgotten.
class RuleExpiry {
 public:
  using Now = std::function<Clock::time_point()>;

  explicit RuleExpiry(Now now = Clock::now);
  ~RuleExpiry();  // stops
  // Nothing expires any more. Waits for a world that is being told; not to be called by it.
  void Stop();

  // When the world is to be told next; nothing: not any more. Replaces what was said of it before.
  void Set(const std::string& uid, std::weak_ptr<World> world,
           std::optional<Clock::time_point> when);

 private:
  struct Due {
    Clock::time_point when;
    std::weak_ptr<World> world;
  };

  void Run();

  const Now now_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Due> due_;  // by the world's uid
  bool stopping_ = false;
  std::thread thread_;  // last: starts when the rest is there
};

}  // namespace cwm::server
