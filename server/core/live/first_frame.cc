#include "server/core/live/first_frame.h"

#include <limits>
#include <utility>

#include "server/core/live/sensor_place.h"

namespace cwm::server {
namespace {

// The returns of the image in the camera's frame; others are not finite.
perception::PointCloud CloudOf(const perception::DepthImage& image,
                               const perception::DepthCamera& camera) {
  const perception::Pinhole& pinhole = camera.pinhole;
  perception::PointCloud cloud;
  cloud.width = image.width;
  cloud.height = image.height;
  cloud.points.reserve(image.depth_m.size());
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const double depth_m = image.at(u, v);
      const Vector3 p_C((u - pinhole.center_u_px) / pinhole.focal_u_px * depth_m,
                        (v - pinhole.center_v_px) / pinhole.focal_v_px * depth_m, depth_m);
      cloud.points.push_back(
          depth_m > 0 ? Eigen::Vector3f(p_C.cast<float>())
                      : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
    }
  }
  return cloud;
}

IngestRequest RequestOf(const SensorCalibration& calibration, const LiveFrame& frame,
                        const ScanInterpreter& by) {
  IngestRequest request;
  request.cloud = CloudOf(*frame.image, frame.camera);
  request.sensor = calibration.sensor;
  request.options.noise = calibration.noise;
  request.options.noise.image_width_px = frame.camera.width;
  request.options.max_threads = by.max_threads;
  request.options.threads_now = by.threads_now;
  request.frame_stamp = frame.stamp;
  request.needs_confirmed_pose = true;
  return request;
}

// The error of the last attempt, for as long as there is no other.
absl::Status LastFailure(const SensorSession& session, Clock::time_point now) {
  const auto failed = session.failed_estimate();
  const bool is_over = !failed.has_value() || now - failed->when >= kFirstFramePeriod;
  return is_over ? absl::OkStatus() : failed->why;
}

bool HasNoPose(const World& world, const SensorCalibration& calibration, bool frame_has_pose) {
  return IsUnplaced(calibration, frame_has_pose, world.SensorPoseOf(calibration.sensor));
}

}  // namespace

bool MustIngestFirst(const World& world, const SensorSession& session, bool frame_has_pose,
                     Clock::time_point now) {
  return HasNoPose(world, session.calibration(), frame_has_pose) && LastFailure(session, now).ok();
}

absl::StatusOr<std::optional<FrameChanges>> IngestFirstFrame(World& world, SensorSession& session,
                                                             const LiveFrame& frame,
                                                             const ScanInterpreter& by,
                                                             std::stop_token stop) {
  const SensorCalibration calibration = session.calibration();
  if (!HasNoPose(world, calibration, frame.X_WC.has_value())) return std::nullopt;
  if (absl::Status failed = LastFailure(session, Clock::now()); !failed.ok()) return failed;
  const auto ingested =
      Ingest(world, RequestOf(calibration, frame, by), by.interpret, std::move(stop));
  if (!ingested.ok()) {
    session.set_failed_estimate(
        SensorSession::FailedEstimate{.when = Clock::now(), .why = ingested.status()});
    return ingested.status();
  }
  session.set_failed_estimate(std::nullopt);
  return FrameChanges{.added = ingested->added,
                      .moved = ingested->moved,
                      .replaced = ingested->replaced,
                      .removed = ingested->removed,
                      .movers = {}};
}

}  // namespace cwm::server
