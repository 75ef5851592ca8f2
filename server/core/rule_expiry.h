// Ends the temporary allowances of pairs when their time on the steady clock is over.
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

// Thread safe. One thread waits for the first expiry of all worlds. It takes the writer's turn to
// publish the expiry, so it waits for writers, never for readers. Worlds are held weakly: an entry
// of a world that is gone is dropped.
class RuleExpiry {
 public:
  using Now = std::function<Clock::time_point()>;

  explicit RuleExpiry(Now now = Clock::now);
  ~RuleExpiry();  // stops
  // Ends the thread; nothing expires any more. Waits for a world's ExpireRules in progress, so it
  // must not be called from there.
  void Stop();

  // Sets the time of the world's next expiry; empty: none. Replaces the previous time.
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
  std::thread thread_;  // last: starts when the other members exist
};

}  // namespace cwm::server
