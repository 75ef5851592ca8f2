// How the frames of one sensor fare.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>

#include "perception/live/frame_evidence.h"
#include "server/core/live/live_frame.h"

namespace cwm::server {

// Not thread safe.
class SensorStatistics {
 public:
  // chosen: quantiles are those of so many frames, eight seconds at 30 Hz.
  static constexpr std::size_t kFrames = 256;
  // chosen: the rate is that of the last seconds, so that it follows what the sensor does now.
  static constexpr auto kRateTime = std::chrono::seconds(5);

  // `delay` is the time between the stamp and the arrival of the frame.
  void NoteProcessed(Clock::time_point now, double latency_ms, double delay_ms);
  void NoteDropped() { ++dropped_; }
  void NoteRefused() { ++refused_; }

  // Fills rate, latencies, delay and counts.
  void Fill(Clock::time_point now, SensorStatus& status) const;

 private:
  struct Entry {
    Clock::time_point when;
    double latency_ms = 0;
    double delay_ms = 0;
  };
  std::deque<Entry> entries_;
  std::int64_t processed_ = 0, dropped_ = 0, refused_ = 0;
};

}  // namespace cwm::server
