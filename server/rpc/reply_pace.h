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

  // From an answer in columns to one that is with a client of this machine, for each byte.
  Seconds OfByte() const { return Seconds(std::max(kLeast_s, kWay * serializing_s_.load())); }

 private:
  static constexpr std::int64_t kMinBytes = 1 << 20;  // smaller ones tell the clock's noise
  // A machine becomes busy at once, and a fast reply says little of the next.
  static constexpr double kSlowerWeight = 0.5, kFasterWeight = 0.05;
  // measured: three times the 1.2 to 1.7 ns of a machine that does little else.
  static constexpr double kLeast_s = 4e-9;
  // measured: copying into columns, serializing, two copies through a socket, parsing.
  static constexpr double kWay = 8;

  std::atomic<double> serializing_s_ = 0;
};

}  // namespace cwm::server
