// Counts what may only be so many.
#pragma once

#include <atomic>
#include <cstdint>

namespace cwm::server {

// Thread safe.
class Quota {
 public:
  explicit Quota(std::int64_t most) : most_(most) {}

  bool TryTake(std::int64_t amount = 1) {
    std::int64_t taken = taken_;
    do {
      if (taken + amount > most_) return false;
    } while (!taken_.compare_exchange_weak(taken, taken + amount));
    return true;
  }
  void GiveBack(std::int64_t amount = 1) { taken_ -= amount; }
  std::int64_t taken() const { return taken_; }
  std::int64_t most() const { return most_; }

 private:
  const std::int64_t most_;
  std::atomic<std::int64_t> taken_ = 0;
};

}  // namespace cwm::server
