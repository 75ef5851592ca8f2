// How long large replies take from their answers to the client.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>

namespace cwm::server {

// Thread safe: an average of the newest replies, of which a lost one does not matter.
class ReplyPace {
 public:
  using Seconds = std::chrono::duration<double>;

  // A reply of so many bytes was serialized within that time.
  void NoteSerialized(std::int64_t bytes, Seconds took) {
    if (bytes < kMinBytes) return;
    const double newest = took.count() / static_cast<double>(bytes), before = serializing_s_.load();
    const double weight = newest > before ? kSlowerWeight : kFasterWeight;
    serializing_s_.store(before * (1 - weight) + newest * weight);
  }

  // How many times longer a reply takes than on a machine that does little else, at least 1.
  double Slowness() const { return std::max(1.0, serializing_s_.load() / kQuietSerializing_s); }

 private:
  static constexpr std::int64_t kMinBytes = 1 << 20;  // smaller ones tell the clock's noise
  // A machine becomes busy at once, and a fast reply says little of the next.
  static constexpr double kSlowerWeight = 0.5, kFasterWeight = 0.05;
  // tuned: seen were 0.07 ns a byte (8 MB into pages that were there) to 3 ns (98 MB into fresh ones).
  static constexpr double kQuietSerializing_s = 0.5e-9;

  std::atomic<double> serializing_s_ = 0;
};

}  // namespace cwm::server
