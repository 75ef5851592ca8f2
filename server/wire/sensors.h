// Running sensors in messages: calibrations, frames and their answers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "cwm/v1/perception.pb.h"
#include "server/core/live/live_frame.h"
#include "server/wire/clouds.h"
#include "server/wire/depth_images.h"
#include "server/wire/field_path.h"

namespace cwm::server {

// Frames that are organised points, seen by a pinhole camera from the origin, in the optical frame.
struct PointsPlan {
  CloudLayout layout;
  int width = 0;
  int height = 0;
  float least_range_m = 0;
  float greatest_range_m = 0;

  std::int64_t byte_count() const { return std::int64_t{layout.point_step} * width * height; }
};

// A checked calibration.
struct SensorPlan {
  std::string world;
  std::string world_uid;  // must match unless empty
  SensorCalibration calibration = {};
  // Exactly one of them is set.
  std::optional<DepthPlan> depth = {};
  std::optional<PointsPlan> points = {};

  std::int64_t frame_bytes() const { return depth ? depth->byte_count() : points->byte_count(); }
  std::int64_t pixel_count() const {
    return depth ? static_cast<std::int64_t>(depth->camera.pixel_count())
                 : std::int64_t{points->width} * points->height;
  }
};

// OK for 1 to 128 characters of which none is a control character.
absl::Status CheckSensorName(const std::string& name, const FieldPath& path);

absl::StatusOr<SensorPlan> SensorPlanFromProto(const v1::SensorCalibration& calibration,
                                               const Limits& limits, const FieldPath& path);

// Reads all of a frame but its image. Without a stamp it was taken when it came. Refuses a stamp
// that is more than kMaxAhead later than `now`.
absl::StatusOr<LiveFrame> FrameFromProto(const v1::SensorFrame& frame,
                                         std::chrono::system_clock::time_point now,
                                         const FieldPath& path);
// chosen: clocks of machines that are synchronised at all differ by less.
inline constexpr auto kMaxAhead = std::chrono::seconds(1);

// Reads the image into `to`. `known` is the camera of earlier frames of points; without it the
// camera is estimated from this frame.
absl::Status ImageFromProto(const v1::SensorFrame& frame, const SensorPlan& plan,
                            const std::optional<perception::DepthCamera>& known,
                            const FieldPath& path, LiveFrame& to);

v1::SensorModel SensorModelToProto(const perception::SensorNoise& noise);
v1::SensorMount SensorMountToProto(const SensorMount& mount);
v1::PixelCounts PixelCountsToProto(const perception::PixelCounts& counts);
v1::StreamCloudsResponse FrameOutcomeToProto(const FrameOutcome& outcome);
v1::Sensor SensorToProto(const SensorStatus& status);
// The frame's points with their classes, evenly thinned to `max_points`; those without a return
// are left out.
v1::WatchFramesResponse DisplayFrameToProto(const DisplayFrame& frame, std::int64_t max_points);

}  // namespace cwm::server
