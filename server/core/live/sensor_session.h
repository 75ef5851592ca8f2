// One sensor of a live world. It stays while the sensor reconnects, with what its view has learnt.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "absl/status/status.h"
#include "perception/live/sensor_view.h"
#include "server/core/live/live_frame.h"
#include "server/core/live/robots_in_view.h"
#include "server/core/live/sensor_statistics.h"
#include "server/core/memory_budget.h"

namespace cwm::server {

// Ends the stream of a sensor for a reason. Called at most once for a stream, from any thread.
using EndStream = std::function<void(const absl::Status& reason)>;

// The state of the comparison of frames: used by one frame after the other, under `mutex`.
struct SensorComparison {
  std::mutex mutex;
  std::unique_ptr<perception::SensorView> view = {};
  perception::DepthCamera camera = {};  // of the view
  RobotsInView robots = {};
  std::optional<Pose> X_WC = {};                 // of the newest frame, as given
  Pose X_WC_used = Pose::Identity();             // at which it was compared
  std::optional<perception::Stamp> newest = {};  // of the processed frames
  // When sightings were recorded last.
  std::optional<perception::Stamp> recorded = {};
  // The effects of interpretations beside the frames, which the next frame's answer tells.
  FrameChanges interpreted = {};
};

// Thread safe, but for `comparison`, which has a lock of its own.
class SensorSession {
 public:
  explicit SensorSession(SensorCalibration calibration);

  SensorComparison comparison;

  // Begins a stream with this calibration. A stream that is open ends with ABORTED
  // SENSOR_TAKEN_OVER. Returns the number by which the stream is known.
  std::uint64_t Begin(SensorCalibration calibration, EndStream end);
  // Ends the stream, unless another one has taken over.
  void End(std::uint64_t stream, Clock::time_point now);
  // OK if the stream has the sensor, else why not.
  absl::Status CheckOwner(std::uint64_t stream) const;
  // Tells the open stream, if there is one, to end.
  void EndOpenStream(const absl::Status& reason);

  SensorCalibration calibration() const;
  // The account of what the view keeps of each pixel, also after the stream's end, until Forget.
  void Hold(MemoryCharge view);
  // The pose that holds from the next frame on.
  void SetPose(const Pose& X_WC);

  // The last attempt to learn the sensor's pose from a frame, if it failed.
  struct FailedEstimate {
    Clock::time_point when = {};
    absl::Status why = {};
  };
  std::optional<FailedEstimate> failed_estimate() const;
  void set_failed_estimate(std::optional<FailedEstimate> failed);

  void NoteProcessed(std::shared_ptr<const DisplayFrame> frame, double delay_ms);
  void NoteDropped();
  void NoteRefused();

  SensorStatus status(Clock::time_point now) const;
  std::shared_ptr<const DisplayFrame> newest_frame() const;  // nullptr: none yet

  bool is_streaming() const;
  // Since when the sensor has been silent: the last frame, or the end of its stream.
  Clock::time_point last_active() const;
  // True if the tracker knows the sensor, which it does from its first frame until it is forgotten.
  bool is_tracked() const;
  void set_tracked(bool is_tracked);
  // Drops the newest frame, which then is no longer shown, and the account of the view.
  void Forget();

 private:
  mutable std::mutex mutex_;  // a leaf
  SensorCalibration calibration_;
  std::uint64_t last_stream_ = 0;
  std::uint64_t open_stream_ = 0;  // 0: none
  EndStream end_;
  MemoryCharge view_;
  std::optional<FailedEstimate> failed_estimate_;
  SensorStatistics statistics_;
  std::shared_ptr<const DisplayFrame> newest_;
  Clock::time_point last_active_ = Clock::now();
  bool is_tracked_ = false;
};

}  // namespace cwm::server
