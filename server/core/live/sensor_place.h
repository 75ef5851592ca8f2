// The pose of a sensor at the stamp of a frame.
#pragma once

#include <optional>
#include <span>

#include "absl/status/statusor.h"
#include "server/core/live/live_frame.h"
#include "server/core/live/robots_in_view.h"
#include "server/core/write_facts.h"

namespace cwm::server {

struct SensorPlace {
  Pose X_WC = Pose::Identity();
  perception::SpatialVelocity V_WC = {};
};

struct PlaceAtStamp {
  Pose X_WC = Pose::Identity();
  perception::Stamp stamp = {};
};

// True if nothing tells the pose of a frame: neither the frame nor its calibration, and the world
// keeps none of an earlier scan. The frame then has to tell it itself (first_frame.h).
bool IsUnplaced(const SensorCalibration& calibration, bool frame_has_pose,
                const std::optional<SensorPose>& kept);

// The frame's own pose wins, then the link that carries the sensor, the pose of the calibration,
// and the one that was given with an earlier scan or estimated from it (`kept`). `before` is the
// place of the sensor's previous frame, which tells the speed of a sensor whose frames have poses.
// FailedPrecondition ROBOT_STATE_MISSING or ROBOT_STATE_STALE if no state tells where the link was;
// InvalidArgument for "frame.x_world_sensor" if nothing tells the pose.
absl::StatusOr<SensorPlace> PlaceAt(const SensorCalibration& calibration, const LiveFrame& frame,
                                    std::span<const RobotAtFrame> robots,
                                    const std::optional<PlaceAtStamp>& before,
                                    const std::optional<SensorPose>& kept);

// NotFound ROBOT_UNKNOWN, FailedPrecondition LINK_UNKNOWN.
absl::Status CheckMount(const SensorMount& mount, const collision::WorldSnapshot& snapshot);

}  // namespace cwm::server
