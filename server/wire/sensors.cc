#include "server/wire/sensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "perception/track/range_view.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

// chosen: longer names are no names; the limit of worlds and objects, too.
constexpr std::int64_t kMaxSensorNameBytes = 128;
// chosen: what a frame has besides its image: stamp, exposure, pose and covariance.
constexpr std::int64_t kMaxFrameHeaderBytes = 4 << 10;
// chosen: beyond, a pose says nothing.
constexpr double kMaxPoseSigma_m = 1, kMaxPoseSigma_rad = 1;
constexpr double kDefaultPoseSigma = 0.005;
constexpr auto kMaxExposure = std::chrono::seconds(10);
constexpr int kCovarianceNumbers = 36;

absl::StatusOr<double> SigmaFromProto(double sigma, double max, const FieldPath& path) {
  if (!(sigma >= 0 && sigma <= max)) {
    return path.Error(absl::StrCat("is ", sigma, ", must be from 0 to ", max));
  }
  return sigma == 0 ? kDefaultPoseSigma : sigma;
}

struct DepthRange {
  float least_m = 0;
  float greatest_m = 0;
};

absl::StatusOr<DepthRange> RangeFromProto(const v1::SensorCalibration& calibration,
                                          const perception::SensorNoise& noise,
                                          const FieldPath& path) {
  const perception::WorkingRange range = perception::RangeOf(noise.model);
  for (const auto& [value, field] :
       {std::pair{calibration.least_range_m(), "least_range_m"},
        std::pair{calibration.greatest_range_m(), "greatest_range_m"}}) {
    if (auto status = CheckLength(value, path.Field(field)); !status.ok()) return status;
  }
  const double least_m =
      calibration.least_range_m() > 0 ? calibration.least_range_m() : range.nearest_m;
  const double greatest_m =
      calibration.greatest_range_m() > 0 ? calibration.greatest_range_m() : range.farthest_m;
  if (least_m < greatest_m) {
    return DepthRange{static_cast<float>(least_m), static_cast<float>(greatest_m)};
  }
  return path.Field("greatest_range_m")
      .Error(absl::StrCat("is ", greatest_m, ", must be more than least_range_m (", least_m, ")"));
}

absl::Status TakePose(const v1::SensorCalibration& proto, const FieldPath& path,
                      SensorCalibration& calibration) {
  if (proto.has_x_world_sensor() && proto.has_mount()) {
    return path.Field("mount").Error("is set beside x_world_sensor, only one of them may be");
  }
  if (proto.has_x_world_sensor()) {
    auto X_WC = PoseFromProto(proto.x_world_sensor(), path.Field("x_world_sensor"));
    if (!X_WC.ok()) return X_WC.status();
    calibration.X_WC = *X_WC;
  }
  if (proto.has_mount()) {
    const FieldPath mount = path.Field("mount");
    SensorMount read{.robot = proto.mount().robot(), .link = proto.mount().link()};
    for (const auto& [name, field] :
         {std::pair{&read.robot, "robot"}, std::pair{&read.link, "link"}}) {
      if (name->empty()) return mount.Field(field).Error("is empty, must name one");
      if (auto status = CheckPrintable(*name, kMaxSensorNameBytes, mount.Field(field));
          !status.ok()) {
        return status;
      }
    }
    if (proto.mount().has_x_link_sensor()) {
      auto X_LC = PoseFromProto(proto.mount().x_link_sensor(), mount.Field("x_link_sensor"));
      if (!X_LC.ok()) return X_LC.status();
      read.X_LC = *X_LC;
    }
    calibration.mount = std::move(read);
  }
  auto sigma_m = SigmaFromProto(proto.pose_sigma_m(), kMaxPoseSigma_m, path.Field("pose_sigma_m"));
  if (!sigma_m.ok()) return sigma_m.status();
  auto sigma_rad =
      SigmaFromProto(proto.pose_sigma_rad(), kMaxPoseSigma_rad, path.Field("pose_sigma_rad"));
  if (!sigma_rad.ok()) return sigma_rad.status();
  calibration.pose_sigma_m = *sigma_m;
  calibration.pose_sigma_rad = *sigma_rad;
  return absl::OkStatus();
}

absl::StatusOr<PointsPlan> PointsPlanFromProto(const v1::SensorCalibration& calibration,
                                               const FieldPath& path) {
  auto layout = CloudLayoutFromProto(calibration.layout(), path.Field("layout"));
  if (!layout.ok()) return layout.status();
  for (const auto& [edge, field] :
       {std::pair{calibration.width(), "width"}, std::pair{calibration.height(), "height"}}) {
    // An image of one row tells no camera.
    const absl::Status valid = CheckRange(edge, {2, kMaxImageEdge_px}, path.Field(field));
    if (!valid.ok()) return valid;
  }
  return PointsPlan{
      .layout = *layout, .width = calibration.width(), .height = calibration.height()};
}

absl::Status CheckImageBytes(std::int64_t bytes, const Limits& limits, const FieldPath& path) {
  const std::int64_t max_bytes = limits.max_message_bytes - kMaxFrameHeaderBytes;
  if (bytes <= max_bytes) return absl::OkStatus();
  return path.Error(
      absl::StrCat("gives frames of ", bytes, " bytes, they must have at most ", max_bytes));
}

absl::StatusOr<perception::DepthCamera> CameraOf(const PointsPlan& plan,
                                                 const perception::PointCloud& cloud,
                                                 const FieldPath& path) {
  const auto pinhole = perception::EstimatePinhole(cloud);
  if (!pinhole.has_value()) {
    return path.Error(
        "fits no pinhole camera to one pixel, must be an image in the optical frame (z forward, x "
        "right, y down) seen from the origin, with returns in several rows and columns");
  }
  return perception::DepthCamera{.pinhole = *pinhole,
                                 .width = plan.width,
                                 .height = plan.height,
                                 .least_range_m = plan.least_range_m,
                                 .greatest_range_m = plan.greatest_range_m};
}

// True if the camera sees the points in their pixels, to two pixels (rms), judged by a sample of
// them. EstimatePinhole demands one pixel, so that an estimate does not change from frame to frame.
bool SeesPoints(const perception::DepthCamera& camera, const perception::PointCloud& cloud) {
  constexpr std::size_t kStep = 31;  // chosen: 10 000 points of 640 x 480 tell enough
  constexpr double kMaxMeanSquare_px2 = 4;
  const perception::Pinhole& pinhole = camera.pinhole;
  double sum_u_px2 = 0, sum_v_px2 = 0;
  int count = 0;
  for (std::size_t i = 0; i < cloud.points.size(); i += kStep) {
    const Eigen::Vector3f& p_C = cloud.points[i];
    if (!p_C.allFinite() || p_C.z() <= 0) continue;
    const Vector3 p = p_C.cast<double>();
    const double u = pinhole.focal_u_px * p.x() / p.z() + pinhole.center_u_px;
    const double v = pinhole.focal_v_px * p.y() / p.z() + pinhole.center_v_px;
    const auto column = i % cloud.width, row = i / cloud.width;
    sum_u_px2 += std::pow(u - static_cast<double>(column), 2);
    sum_v_px2 += std::pow(v - static_cast<double>(row), 2);
    ++count;
  }
  return std::max(sum_u_px2, sum_v_px2) <= kMaxMeanSquare_px2 * count;
}

absl::Status PointsFromProto(const v1::SensorFrame& frame, const PointsPlan& plan,
                             const std::optional<perception::DepthCamera>& known,
                             const FieldPath& path, LiveFrame& to) {
  const FieldPath points_path = path.Field("points");
  if (static_cast<std::int64_t>(frame.points().size()) != plan.byte_count()) {
    return points_path.Error(absl::StrCat("has ", frame.points().size(), " bytes, must have ",
                                          plan.byte_count(), " (", plan.width, " x ", plan.height,
                                          " x ", plan.layout.point_step, ")"));
  }
  perception::PointCloud cloud;
  cloud.width = plan.width;
  cloud.height = plan.height;
  cloud.points =
      ReadPoints(plan.layout, frame.points(), static_cast<std::size_t>(plan.width) * plan.height);
  const bool is_known = known.has_value() && known->width == plan.width &&
                        known->height == plan.height && SeesPoints(*known, cloud);
  auto camera = is_known ? *known : CameraOf(plan, cloud, points_path);
  if (!camera.ok()) return camera.status();
  camera->least_range_m = plan.least_range_m;
  camera->greatest_range_m = plan.greatest_range_m;
  auto image = std::make_shared<perception::DepthImage>();
  image->width = plan.width;
  image->height = plan.height;
  image->depth_m.reserve(cloud.points.size());
  for (const Eigen::Vector3f& p : cloud.points) {
    const bool is_return =
        p.allFinite() && p.z() >= plan.least_range_m && p.z() <= plan.greatest_range_m && p.z() > 0;
    image->depth_m.push_back(is_return ? p.z() : 0.0F);
  }
  to.camera = *camera;
  to.image = std::move(image);
  return absl::OkStatus();
}

template <class Names>
void SetNames(const std::vector<std::string>& names, Names* to) {
  for (const std::string& name : names) *to->Add() = name;
}

v1::FrameFate FrameFateToProto(FrameFate fate) {
  switch (fate) {
    case FrameFate::kProcessed:
      return v1::FRAME_FATE_PROCESSED;
    case FrameFate::kDropped:
      return v1::FRAME_FATE_DROPPED;
    case FrameFate::kRefused:
      return v1::FRAME_FATE_REFUSED;
  }
  return v1::FRAME_FATE_UNSPECIFIED;
}

}  // namespace

absl::Status CheckSensorName(const std::string& name, const FieldPath& path) {
  if (name.empty()) return path.Error("is empty, must be a name of 1 to 128 characters");
  return CheckPrintable(name, kMaxSensorNameBytes, path);
}

absl::StatusOr<SensorPlan> SensorPlanFromProto(const v1::SensorCalibration& calibration,
                                               const Limits& limits, const FieldPath& path) {
  SensorPlan plan{.world = calibration.world(), .world_uid = calibration.world_uid()};
  const FieldPath name_path = path.Field("sensor");
  if (auto status = CheckSensorName(calibration.sensor(), name_path); !status.ok()) return status;
  plan.calibration.sensor = calibration.sensor();
  plan.calibration.in_lockstep = calibration.lockstep();
  auto noise = SensorNoiseFromProto(calibration.sensor_model(), path.Field("sensor_model"));
  if (!noise.ok()) return noise.status();
  if (auto status = TakePose(calibration, path, plan.calibration); !status.ok()) return status;
  auto range = RangeFromProto(calibration, *noise, path);
  if (!range.ok()) return range.status();
  if (calibration.has_depth() == calibration.has_layout()) {
    return path.Field("depth").Error(calibration.has_depth()
                                         ? "is set beside layout, only one of them may be"
                                         : "is absent as is layout, one of them must be set");
  }
  int width_px = 0;
  if (calibration.has_depth()) {
    const FieldPath depth_path = path.Field("depth");
    auto depth = DepthPlanFromProto(calibration.depth(), depth_path);
    if (!depth.ok()) return depth.status();
    depth->camera.least_range_m = range->least_m;
    depth->camera.greatest_range_m = range->greatest_m;
    width_px = depth->camera.width;
    plan.depth = *depth;
    if (auto status = CheckImageBytes(plan.frame_bytes(), limits, depth_path); !status.ok()) {
      return status;
    }
  } else {
    auto points = PointsPlanFromProto(calibration, path);
    if (!points.ok()) return points.status();
    points->least_range_m = range->least_m;
    points->greatest_range_m = range->greatest_m;
    width_px = points->width;
    plan.points = *points;
    if (auto status = CheckImageBytes(plan.frame_bytes(), limits, path.Field("layout"));
        !status.ok()) {
      return status;
    }
  }
  noise->image_width_px = width_px;
  plan.calibration.noise = *noise;
  return plan;
}

absl::StatusOr<LiveFrame> FrameFromProto(const v1::SensorFrame& frame,
                                         std::chrono::system_clock::time_point now,
                                         const FieldPath& path) {
  LiveFrame read;
  read.stamp = now;
  if (frame.has_frame_stamp()) {
    const FieldPath stamp_path = path.Field("frame_stamp");
    auto stamp = TimePointFromProto(frame.frame_stamp(), stamp_path);
    if (!stamp.ok()) return stamp.status();
    if (*stamp - now > kMaxAhead) {
      const std::chrono::duration<double> ahead = *stamp - now;
      return stamp_path.Error(absl::StrCat("is ", ahead.count(),
                                           " s ahead of the server's clock, must be at most ",
                                           kMaxAhead.count(), " s ahead"));
    }
    read.stamp = *stamp;
  }
  if (frame.has_exposure()) {
    auto exposure = DurationFromProto(frame.exposure(), path.Field("exposure"), kMaxExposure);
    if (!exposure.ok()) return exposure.status();
    read.exposure = *exposure;
  }
  if (frame.has_x_world_sensor()) {
    auto X_WC = PoseFromProto(frame.x_world_sensor(), path.Field("x_world_sensor"));
    if (!X_WC.ok()) return X_WC.status();
    read.X_WC = *X_WC;
  }
  const int numbers = frame.pose_covariance_size();
  if (numbers != 0 && numbers != kCovarianceNumbers) {
    return path.Field("pose_covariance")
        .Error(absl::StrCat("holds ", numbers, " numbers, must hold 0 or ", kCovarianceNumbers));
  }
  for (int i = 0; i < numbers; ++i) {
    const double value = frame.pose_covariance(i);
    const bool is_variance = i % 7 == 0;
    if (std::isfinite(value) && (!is_variance || value >= 0)) continue;
    return path.Item("pose_covariance", i)
        .Error(absl::StrCat("is ", value, ", must be finite, and a variance not negative"));
  }
  if (numbers != 0) {
    const auto sigma = [&frame](int first) {  // of three coordinates
      double variance = 0;
      for (const int i : {first, first + 1, first + 2})
        variance += frame.pose_covariance(7 * i) / 3;
      return std::sqrt(variance);
    };
    read.pose_sigma = {.translation_m = sigma(0), .rotation_rad = sigma(3)};
  }
  return read;
}

absl::Status ImageFromProto(const v1::SensorFrame& frame, const SensorPlan& plan,
                            const std::optional<perception::DepthCamera>& known,
                            const FieldPath& path, LiveFrame& to) {
  if (plan.points.has_value()) {
    if (!frame.has_points()) {
      return path.Field("points").Error("is absent, must be set as the calibration says");
    }
    return PointsFromProto(frame, *plan.points, known, path, to);
  }
  const FieldPath depth_path = path.Field("depth");
  if (!frame.has_depth()) return depth_path.Error("is absent, must be set as the calibration says");
  auto image = DecodeDepth(*plan.depth, frame.depth(), depth_path);
  if (!image.ok()) return image.status();
  to.camera = plan.depth->camera;
  to.image = *std::move(image);
  return absl::OkStatus();
}

v1::SensorModel SensorModelToProto(const perception::SensorNoise& noise) {
  v1::SensorModel model;
  switch (noise.model) {
    case perception::SensorModel::kRealSense:
      model.set_kind(v1::SensorModel::KIND_REALSENSE);
      break;
    case perception::SensorModel::kTimeOfFlight:
      model.set_kind(v1::SensorModel::KIND_TIME_OF_FLIGHT);
      break;
    case perception::SensorModel::kTiltingLaser:
      model.set_kind(v1::SensorModel::KIND_TILTING_LASER);
      break;
    case perception::SensorModel::kGiven:
      model.set_sigma_m(noise.given_sigma_m);
      model.set_quadratic_per_m(noise.given_quadratic_per_m);
      model.set_kind(noise.given_quadratic_per_m > 0 ? v1::SensorModel::KIND_QUADRATIC
                                                     : v1::SensorModel::KIND_CONSTANT);
      break;
    default:
      model.set_kind(v1::SensorModel::KIND_KINECT);
  }
  return model;
}

v1::SensorMount SensorMountToProto(const SensorMount& mount) {
  v1::SensorMount proto;
  proto.set_robot(mount.robot);
  proto.set_link(mount.link);
  *proto.mutable_x_link_sensor() = PoseToProto(mount.X_LC);
  return proto;
}

v1::PixelCounts PixelCountsToProto(const perception::PixelCounts& counts) {
  using perception::PixelClass;
  const auto count = [&](PixelClass of) { return counts[static_cast<std::size_t>(of)]; };
  v1::PixelCounts proto;
  proto.set_consistent(count(PixelClass::kConsistent));
  proto.set_nearer(count(PixelClass::kNearer));
  proto.set_farther(count(PixelClass::kFarther));
  proto.set_missing(count(PixelClass::kMissing));
  proto.set_robot(count(PixelClass::kRobot));
  proto.set_carried(count(PixelClass::kCarried));
  proto.set_mixed(count(PixelClass::kMixed));
  proto.set_hidden(count(PixelClass::kHidden));
  return proto;
}

v1::StreamCloudsResponse FrameOutcomeToProto(const FrameOutcome& outcome) {
  v1::StreamCloudsResponse proto;
  proto.set_fate(FrameFateToProto(outcome.fate));
  proto.set_reason(outcome.reason);
  proto.set_message(outcome.message);
  proto.set_revision(outcome.revision.value);
  if (outcome.fate != FrameFate::kProcessed) return proto;
  v1::FrameChanges& changes = *proto.mutable_changes();
  SetNames(outcome.changes.added, changes.mutable_added());
  SetNames(outcome.changes.moved, changes.mutable_moved());
  SetNames(outcome.changes.replaced, changes.mutable_replaced());
  SetNames(outcome.changes.removed, changes.mutable_removed());
  SetNames(outcome.changes.movers, changes.mutable_movers());
  *proto.mutable_pixels() = PixelCountsToProto(outcome.pixels);
  *proto.mutable_x_world_sensor() = PoseToProto(outcome.X_WC);
  if (outcome.robot_state_age_ms.has_value()) {
    proto.set_robot_state_age_ms(*outcome.robot_state_age_ms);
  }
  for (const perception::StageTime& stage : outcome.stages) {
    v1::StageTime* time = proto.add_stages();
    time->set_stage(stage.stage);
    time->set_elapsed_ms(stage.elapsed_ms);
  }
  proto.set_interpreting(outcome.interpreting);
  proto.set_sequence_number(static_cast<std::int64_t>(outcome.number));
  return proto;
}

v1::Sensor SensorToProto(const SensorStatus& status) {
  v1::Sensor proto;
  proto.set_name(status.calibration.sensor);
  proto.set_is_streaming(status.is_streaming);
  if (status.last_frame.has_value()) {
    *proto.mutable_x_world_sensor() = PoseToProto(status.X_WC);
    *proto.mutable_last_frame() = TimePointToProto(*status.last_frame);
  } else if (status.calibration.X_WC.has_value()) {
    *proto.mutable_x_world_sensor() = PoseToProto(*status.calibration.X_WC);
  }
  if (status.calibration.mount.has_value()) {
    *proto.mutable_mount() = SensorMountToProto(*status.calibration.mount);
  }
  *proto.mutable_sensor_model() = SensorModelToProto(status.calibration.noise);
  proto.set_frame_rate(status.frame_rate_Hz);
  proto.set_latency_p50_ms(status.latency_p50_ms);
  proto.set_latency_p95_ms(status.latency_p95_ms);
  proto.set_processed_count(status.processed);
  proto.set_dropped_count(status.dropped);
  proto.set_refused_count(status.refused);
  if (status.delay_ms.has_value()) proto.set_delay_ms(*status.delay_ms);
  if (status.estimate.has_value()) {
    v1::SensorPoseEstimate& estimate = *proto.mutable_estimate();
    *estimate.mutable_x_world_sensor() = PoseToProto(status.estimate->X_WC);
    estimate.set_translation_error_m(status.estimate->translation_error_m);
    estimate.set_rotation_error_rad(status.estimate->rotation_error_rad);
    estimate.set_sigma_m(status.estimate->sigma_m);
    estimate.set_sigma_rad(status.estimate->sigma_rad);
    estimate.set_surface_count(status.estimate->patches);
  }
  proto.set_estimate_note(status.estimate_note);
  SetNames(status.conflicts, proto.mutable_conflicts());
  return proto;
}

v1::WatchFramesResponse DisplayFrameToProto(const DisplayFrame& frame, std::int64_t max_points) {
  v1::WatchFramesResponse proto;
  proto.set_revision(frame.revision.value);
  proto.set_sensor(frame.sensor);
  *proto.mutable_frame_stamp() = TimePointToProto(frame.stamp);
  *proto.mutable_x_world_sensor() = PoseToProto(frame.X_WC);
  *proto.mutable_pixels() = PixelCountsToProto(frame.classes->counts);
  proto.set_latency_ms(frame.latency_ms);
  // Every step-th pixel of every step-th row.
  const auto pixels = static_cast<double>(frame.camera.pixel_count());
  const int step =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / static_cast<double>(max_points)))));
  const perception::Pinhole& pinhole = frame.camera.pinhole;
  std::string& points = *proto.mutable_points();
  std::string& classes = *proto.mutable_classes();
  for (int v = 0; v < frame.camera.height; v += step) {
    for (int u = 0; u < frame.camera.width; u += step) {
      const double depth_m = frame.image->at(u, v);
      if (!(depth_m > 0)) continue;
      const Vector3 p_C(depth_m * (u - pinhole.center_u_px) / pinhole.focal_u_px,
                        depth_m * (v - pinhole.center_v_px) / pinhole.focal_v_px, depth_m);
      const Eigen::Vector3f p_W = (frame.X_WC * p_C).cast<float>();
      points.append(reinterpret_cast<const char*>(p_W.data()), sizeof(p_W));
      const std::size_t pixel = static_cast<std::size_t>(v) * frame.camera.width + u;
      classes.push_back(static_cast<char>(frame.classes->pixels[pixel]));
    }
  }
  return proto;
}

}  // namespace cwm::server
