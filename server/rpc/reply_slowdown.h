// Measures how long large replies take to reach the client.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>

namespace cwm::server {

// Thread safe: an average of the newest replies. A lost update does not matter.
class ReplySlowdown {
 public:
  using Seconds = std::chrono::duration<double>;

  // Records that a reply of `bytes` bytes was serialized within `took`.
  void NoteSerialized(std::int64_t bytes, Seconds took) {
    if (bytes < kMinBytes) return;
    const double newest = took.count() / static_cast<double>(bytes), before = serializing_s_.load();
    const double weight = newest > before ? kSlowerWeight : kFasterWeight;
    serializing_s_.store(before * (1 - weight) + newest * weight);
  }

  // The factor by which replies take longer than on an otherwise idle machine, at least 1.
  double Factor() const { return std::max(1.0, serializing_s_.load() / kQuietSerializing_s); }

 private:
  static constexpr std::int64_t kMinBytes = 1 << 20;  // smaller ones measure clock noise
  // A machine becomes busy at once, while a single fast reply says little about the next.
  static constexpr double kSlowerWeight = 0.5, kFasterWeight = 0.05;
  // tuned: between the measured 0.07 ns per byte (8 MB into mapped pages) and 3 ns (98 MB into
  // fresh ones).
  static constexpr double kQuietSerializing_s = 0.5e-9;

  std::atomic<double> serializing_s_ = 0;
};

}  // namespace cwm::server
