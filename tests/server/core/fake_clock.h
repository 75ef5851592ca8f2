// A clock that stands still until the test advances it.
#pragma once

#include <functional>
#include <memory>

#include "server/core/limits.h"

namespace cwm::server {

class FakeClock {
 public:
  std::function<Clock::time_point()> now() const {
    return [time = time_] { return *time; };
  }
  void Advance(Clock::duration by) { *time_ += by; }

 private:
  std::shared_ptr<Clock::time_point> time_ = std::make_shared<Clock::time_point>(Clock::now());
};

}  // namespace cwm::server
