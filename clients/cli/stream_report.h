// The report of a stream of frames: counts, latency and changes.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <iosfwd>
#include <map>
#include <string>

#include "cwm/v1/perception.pb.h"

namespace cwm::cli {

// Counts latencies in steps of 2 %, from 0.01 ms to 100 s, so that its size does not grow.
class LatencyHistogram {
 public:
  void Add(double latency_ms);
  // The latency that a share of all is below; 0 without any.
  double Quantile(double share) const;

 private:
  static constexpr std::size_t kSteps = 814;  // derived: ln(1e7) / ln(1.02)
  std::array<std::int64_t, kSteps> counts_ = {};
  std::int64_t count_ = 0;
};

class StreamReport {
 public:
  using Clock = std::chrono::steady_clock;

  // `latency` is the time from the frame's first byte sent to its answer.
  void Add(const cwm::v1::StreamCloudsResponse& answer, Clock::duration latency,
           Clock::time_point now);

  std::int64_t answered() const { return processed_ + dropped_ + refused_; }
  std::int64_t processed() const { return processed_; }
  // Refused frames by their reason.
  const std::map<std::string, std::int64_t>& reasons() const { return reasons_; }

  // "200 frames, 29.8/s, latency 4.1 ms, 16 changes, 1 dropped": rate and latency are the median
  // of the newest frames.
  std::string Line() const;
  // The summary for people.
  void Print(std::ostream& out) const;

 private:
  struct Answer {
    Clock::time_point time;
    double latency_ms;
  };
  double RecentRate() const;
  double RecentLatency() const;

  std::int64_t processed_ = 0, dropped_ = 0, refused_ = 0, revision_ = 0;
  std::map<std::string, std::int64_t> reasons_;
  std::int64_t added_ = 0, moved_ = 0, replaced_ = 0, removed_ = 0, mover_frames_ = 0;
  LatencyHistogram latencies_;  // of processed frames
  std::deque<Answer> recent_;   // of processed frames
  Clock::time_point first_ = {}, last_ = {};
};

}  // namespace cwm::cli
