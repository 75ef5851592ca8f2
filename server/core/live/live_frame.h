// One frame of a running sensor, and what became of it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/world/world_object.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/sensor_alignment.h"
#include "perception/scene_interpretation.h"
#include "server/core/limits.h"

namespace cwm::server {

// The place of a sensor on a robot of the world.
struct SensorMount {
  std::string robot;
  std::string link;
  Pose X_LC = Pose::Identity();  // the sensor in the link's frame
};

struct SensorCalibration {
  std::string sensor = {};
  perception::SensorNoise noise = {};
  // At most one of them is set. Neither: frames have their poses, or the world keeps one.
  std::optional<Pose> X_WC = {};
  std::optional<SensorMount> mount = {};
  // Standard deviations of the given pose.
  double pose_sigma_m = 0.005;
  double pose_sigma_rad = 0.005;
  bool in_lockstep = false;  // its frames take turns, see Lockstep
  perception::PoseSigma pose_sigma() const {
    return {.translation_m = pose_sigma_m, .rotation_rad = pose_sigma_rad};
  }
};

struct LiveFrame {
  perception::Stamp stamp = {};  // the middle of the exposure
  std::chrono::nanoseconds exposure = {};
  std::optional<Pose> X_WC = {};  // of this moment; wins over the calibration
  // Of that pose; empty: as in the calibration.
  std::optional<perception::PoseSigma> pose_sigma = {};
  perception::DepthCamera camera = {};
  std::shared_ptr<const perception::DepthImage> image = {};
  Clock::time_point received = {};  // when its last byte came
  Clock::time_point begun = {};     // when its work began: the end of the stage `receive`
  Clock::time_point decoded = {};   // when the image was there: the end of the stage `decode`
};

enum class FrameFate { kProcessed, kDropped, kRefused };

// The effects of a frame on the world, by object name.
struct FrameChanges {
  std::vector<std::string> added, moved, replaced, removed, movers;

  void Append(const FrameChanges& other) {
    using Names = std::vector<std::string> FrameChanges::*;
    for (const Names names : {&FrameChanges::added, &FrameChanges::moved, &FrameChanges::replaced,
                              &FrameChanges::removed, &FrameChanges::movers}) {
      (this->*names).insert((this->*names).end(), (other.*names).begin(), (other.*names).end());
    }
  }
};

struct FrameOutcome {
  FrameFate fate = FrameFate::kProcessed;
  // In the order in which the frames of all sensors were taken into the world, from 1; 0: it was not
  // processed.
  std::uint64_t number = 0;
  // Of a frame that was refused, or processed with reservations.
  std::string reason = {};
  std::string message = {};
  collision::Revision revision = {};
  FrameChanges changes = {};
  perception::PixelCounts pixels = {};
  Pose X_WC = Pose::Identity();                    // that was used
  std::optional<double> robot_state_age_ms = {};   // of the robots in the world
  std::vector<perception::StageTime> stages = {};  // from the frame's last byte to now
  bool interpreting = false;  // a region of the view is being interpreted beside the frames
};

// The facts about a sensor that streams or has streamed.
struct SensorStatus {
  SensorCalibration calibration = {};
  bool is_streaming = false;
  Pose X_WC = Pose::Identity();  // of its newest frame
  std::optional<perception::Stamp> last_frame = {};
  double frame_rate_Hz = 0;  // of processed frames
  double latency_p50_ms = 0;
  double latency_p95_ms = 0;
  std::int64_t processed = 0;
  std::int64_t dropped = 0;
  std::int64_t refused = 0;
  std::optional<double> delay_ms = {};  // between stamps and arrival, the least
  // By what it and other sensors see at rest; the note says why there is none.
  std::optional<perception::SensorPoseEstimate> estimate = {};
  std::string estimate_note = {};
  std::vector<std::string> conflicts = {};  // with other sensors, in words, the greatest first
};

// A processed frame for display.
struct DisplayFrame {
  std::uint64_t number = 0;  // as in its FrameOutcome
  std::string sensor = {};
  perception::Stamp stamp = {};
  Pose X_WC = Pose::Identity();
  perception::DepthCamera camera = {};
  std::shared_ptr<const perception::DepthImage> image = {};
  std::shared_ptr<const perception::FrameClasses> classes = {};
  collision::Revision revision = {};
  double latency_ms = 0;
};

}  // namespace cwm::server
