#include "cwm/live.h"

#include <atomic>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/sensor_stream.h"
#include "cwm/internal/session.h"
#include "cwm/internal/world_messages.h"
#include "cwm/world.h"

namespace cwm::CWM_API {
namespace {

using internal::ThrowBadArgument;

// Three of translation and three of rotation.
constexpr int kPoseParameters = 6;

v1::SensorMount ToMessage(const SensorMount& mount) {
  v1::SensorMount message;
  message.set_robot(mount.robot);
  message.set_link(mount.link);
  *message.mutable_x_link_sensor() = internal::ToMessage(mount.X_LS, "calibration.mount.X_LS");
  return message;
}

v1::SensorCalibration ToMessage(const SensorCalibration& calibration, const std::string& world) {
  if (calibration.width < 1 || calibration.height < 1) {
    ThrowBadArgument("calibration.width", absl::StrCat("and height are ", calibration.width, " x ",
                                                       calibration.height, ", must be positive"));
  }
  v1::SensorCalibration message;
  message.set_world(world);
  message.set_sensor(calibration.sensor);
  internal::SetSensor(calibration.model, *message.mutable_sensor_model());
  if (calibration.X_WS) {
    *message.mutable_x_world_sensor() = internal::ToMessage(*calibration.X_WS, "calibration.X_WS");
  }
  if (calibration.mount) *message.mutable_mount() = ToMessage(*calibration.mount);
  v1::DepthLayout& depth = *message.mutable_depth();
  depth.set_type(static_cast<v1::DepthType>(calibration.depth_type));
  depth.set_width(calibration.width);
  depth.set_height(calibration.height);
  depth.set_unit_m(calibration.unit_m);
  depth.mutable_pinhole()->set_fx_px(calibration.pinhole.fx_px);
  depth.mutable_pinhole()->set_fy_px(calibration.pinhole.fy_px);
  depth.mutable_pinhole()->set_cx_px(calibration.pinhole.cx_px);
  depth.mutable_pinhole()->set_cy_px(calibration.pinhole.cy_px);
  message.set_least_range_m(calibration.min_range_m);
  message.set_greatest_range_m(calibration.max_range_m);
  message.set_pose_sigma_m(calibration.pose_sigma_m);
  message.set_pose_sigma_rad(calibration.pose_sigma_rad);
  message.set_lockstep(calibration.lockstep);
  return message;
}

v1::SensorFrame ToMessage(const FrameInfo& frame) {
  v1::SensorFrame message;
  *message.mutable_frame_stamp() = internal::ToMessage(frame.stamp);
  if (frame.exposure_s != 0) {
    *message.mutable_exposure() = internal::DurationFrom(frame.exposure_s, "frame.exposure_s");
  }
  if (frame.X_WS)
    *message.mutable_x_world_sensor() = internal::ToMessage(*frame.X_WS, "frame.X_WS");
  if (!frame.covariance) return message;
  for (int i = 0; i < kPoseParameters; ++i) {
    for (int j = 0; j < kPoseParameters; ++j) {
      message.add_pose_covariance((*frame.covariance)(i, j));
    }
  }
  return message;
}

std::vector<std::string> NamesFrom(const google::protobuf::RepeatedPtrField<std::string>& names) {
  return {names.begin(), names.end()};
}

FrameResult FromMessage(const v1::StreamCloudsResponse& message) {
  const v1::FrameChanges& changes = message.changes();
  const v1::PixelCounts& pixels = message.pixels();
  FrameResult result{.frame = message.frame(),
                     .stamp = internal::FromMessage(message.frame_stamp()),
                     .fate = static_cast<FrameFate>(message.fate()),
                     .reason = message.reason(),
                     .message = message.message(),
                     .world_uid = message.world_uid(),
                     .revision = message.revision(),
                     .changes = {.added = NamesFrom(changes.added()),
                                 .moved = NamesFrom(changes.moved()),
                                 .replaced = NamesFrom(changes.replaced()),
                                 .removed = NamesFrom(changes.removed()),
                                 .movers = NamesFrom(changes.movers())},
                     .pixels = {.consistent = pixels.consistent(),
                                .nearer = pixels.nearer(),
                                .farther = pixels.farther(),
                                .missing = pixels.missing(),
                                .robot = pixels.robot(),
                                .carried = pixels.carried(),
                                .mixed = pixels.mixed(),
                                .hidden = pixels.hidden()}};
  result.X_WS = internal::FromMessage(message.x_world_sensor());
  if (message.has_robot_state_age_ms()) result.robot_state_age_ms = message.robot_state_age_ms();
  for (const v1::StageTime& stage : message.stages()) {
    result.stages_ms.emplace_back(stage.stage(), stage.elapsed_ms());
  }
  result.interpreting = message.interpreting();
  result.sequence_number = message.sequence_number();
  return result;
}

Sensor FromMessage(const v1::Sensor& message) {
  Sensor sensor{.name = message.name(), .is_streaming = message.is_streaming()};
  sensor.X_WS = internal::FromMessage(message.x_world_sensor());
  if (message.has_mount()) {
    sensor.mount = SensorMount{.robot = message.mount().robot(),
                               .link = message.mount().link(),
                               .X_LS = internal::FromMessage(message.mount().x_link_sensor())};
  }
  if (message.has_last_frame()) sensor.last_frame = internal::FromMessage(message.last_frame());
  sensor.frame_rate_hz = message.frame_rate();
  sensor.latency_p50_ms = message.latency_p50_ms();
  sensor.latency_p95_ms = message.latency_p95_ms();
  sensor.processed_count = message.processed_count();
  sensor.dropped_count = message.dropped_count();
  sensor.refused_count = message.refused_count();
  if (message.has_estimate()) {
    const v1::SensorPoseEstimate& estimate = message.estimate();
    sensor.estimate = SensorPoseEstimate{.X_WS = internal::FromMessage(estimate.x_world_sensor()),
                                         .translation_error_m = estimate.translation_error_m(),
                                         .rotation_error_rad = estimate.rotation_error_rad(),
                                         .sigma_m = estimate.sigma_m(),
                                         .sigma_rad = estimate.sigma_rad(),
                                         .surface_count = estimate.surface_count()};
  }
  if (message.has_delay_ms()) sensor.delay_ms = message.delay_ms();
  sensor.conflicts = NamesFrom(message.conflicts());
  return sensor;
}

}  // namespace

// The call StreamClouds.
class SensorStream::Call {
 public:
  Call(std::shared_ptr<internal::Session> session, const v1::SensorCalibration& calibration)
      : session_(std::move(session)),
        type_(static_cast<DepthType>(calibration.depth().type())),
        pixel_count_(static_cast<std::size_t>(calibration.depth().width()) *
                     static_cast<std::size_t>(calibration.depth().height())),
        stream_(session_->connection, calibration) {}

  template <class Depth>
  std::int64_t Send(DepthType type, std::span<const Depth> depths, const FrameInfo& frame) {
    if (type != type_) {
      ThrowBadArgument("depths",
                       absl::StrCat("are ", type == DepthType::kU16 ? "integers" : "floats",
                                    ", must be of calibration.depth_type"));
    }
    if (depths.size() != pixel_count_) {
      ThrowBadArgument("depths", absl::StrCat("are ", depths.size(), ", must be ", pixel_count_,
                                              ", width x height of the calibration"));
    }
    v1::SensorFrame message = ToMessage(frame);
    message.set_depth(depths.data(), depths.size_bytes());
    if (!stream_.Send(std::move(message))) ThrowEnd();
    return sent_count_++;
  }

  std::optional<FrameResult> Next() {
    if (const auto answer = stream_.Next()) return FromMessage(*answer);
    const absl::Status end = stream_.Finish();
    if (end.ok() || is_closed_) return std::nullopt;
    internal::Throw(end, session_->connection);
  }

  FrameResult Await(std::int64_t frame) {
    while (auto result = Next()) {
      if (result->frame == frame) return *std::move(result);
    }
    throw Error(ErrorCode::kCancelled, "the stream was closed before the frame was answered");
  }

  void Finish() { stream_.CloseFrames(); }
  void Close() {
    is_closed_ = true;
    stream_.Cancel();
  }

 private:
  // Answers that were not read yet are behind the end.
  [[noreturn]] void ThrowEnd() {
    while (stream_.Next()) {
    }
    const absl::Status end = stream_.Finish();
    if (!end.ok()) internal::Throw(end, session_->connection);
    throw Error(ErrorCode::kUnavailable, "the server ended the stream");
  }

  const std::shared_ptr<internal::Session> session_;
  const DepthType type_;
  const std::size_t pixel_count_;
  std::int64_t sent_count_ = 0;
  std::atomic<bool> is_closed_ = false;
  client::SensorStream stream_;
};

SensorStream::SensorStream(std::unique_ptr<Call> call) : call_(std::move(call)) {}
SensorStream::~SensorStream() = default;
SensorStream::SensorStream(SensorStream&&) noexcept = default;
SensorStream& SensorStream::operator=(SensorStream&&) noexcept = default;

std::int64_t SensorStream::Send(std::span<const std::uint16_t> depths, const FrameInfo& frame) {
  return call_->Send(DepthType::kU16, depths, frame);
}
std::int64_t SensorStream::Send(std::span<const float> depths, const FrameInfo& frame) {
  return call_->Send(DepthType::kF32, depths, frame);
}
std::optional<FrameResult> SensorStream::Next() { return call_->Next(); }
FrameResult SensorStream::Process(std::span<const std::uint16_t> depths, const FrameInfo& frame) {
  return call_->Await(Send(depths, frame));
}
FrameResult SensorStream::Process(std::span<const float> depths, const FrameInfo& frame) {
  return call_->Await(Send(depths, frame));
}
void SensorStream::Finish() { call_->Finish(); }
void SensorStream::Close() { call_->Close(); }

// The call StreamRobotStates.
class RobotStateStream::Call {
 public:
  Call(std::shared_ptr<internal::Session> session, v1::RobotStatesHeader header)
      : session_(std::move(session)), stream_(session_->connection, std::move(header)) {}

  void Send(v1::RobotStateRows rows) {
    if (!stream_.Send(std::move(rows))) Finish();
  }

  RobotStatesSummary Finish() {
    const auto reply = stream_.Finish();
    if (!reply.ok()) internal::Throw(reply.status(), session_->connection);
    return {.world_uid = reply->world_uid(),
            .revision = reply->revision(),
            .state_count = reply->state_count(),
            .ignored_count = reply->ignored_count()};
  }

 private:
  const std::shared_ptr<internal::Session> session_;
  client::RobotStateStream stream_;
};

RobotStateStream::RobotStateStream(std::unique_ptr<Call> call) : call_(std::move(call)) {}
RobotStateStream::~RobotStateStream() = default;
RobotStateStream::RobotStateStream(RobotStateStream&&) noexcept = default;
RobotStateStream& RobotStateStream::operator=(RobotStateStream&&) noexcept = default;

void RobotStateStream::Send(Time stamp, const Eigen::Ref<const Eigen::VectorXd>& values,
                            const std::optional<Eigen::Isometry3d>& X_WB) {
  Send(std::span<const Time>(&stamp, 1), values,
       X_WB ? std::span<const Eigen::Isometry3d>(&*X_WB, 1) : std::span<const Eigen::Isometry3d>());
}

void RobotStateStream::Send(std::span<const Time> stamps,
                            const Eigen::Ref<const Eigen::MatrixXd>& values,
                            std::span<const Eigen::Isometry3d> X_WB) {
  if (static_cast<std::size_t>(values.cols()) != stamps.size()) {
    ThrowBadArgument("values", absl::StrCat("has ", values.cols(), " columns, must have ",
                                            stamps.size(), ", one for each stamp"));
  }
  if (!X_WB.empty() && X_WB.size() != stamps.size()) {
    ThrowBadArgument("X_WB", absl::StrCat("are ", X_WB.size(), ", must be ", stamps.size(),
                                          ", one for each stamp, or none"));
  }
  v1::RobotStateRows rows;
  for (const Time stamp : stamps) *rows.add_stamps() = internal::ToMessage(stamp);
  const Eigen::MatrixXd columns = values;  // dense
  rows.mutable_rows()->set_scalar(v1::SCALAR_F64);
  rows.mutable_rows()->set_width(static_cast<int>(columns.rows()));
  rows.mutable_rows()->set_data(columns.data(),
                                static_cast<std::size_t>(columns.size()) * sizeof(double));
  for (std::size_t i = 0; i < X_WB.size(); ++i) {
    const auto numbers = internal::PoseNumbers(X_WB[i], absl::StrCat("X_WB[", i, "]"));
    rows.mutable_x_world_base()->set_scalar(v1::SCALAR_F64);
    rows.mutable_x_world_base()->mutable_data()->append(
        reinterpret_cast<const char*>(numbers.data()), sizeof(numbers));
  }
  call_->Send(std::move(rows));
}

RobotStatesSummary RobotStateStream::Finish() { return call_->Finish(); }

SensorStream World::StreamSensor(const SensorCalibration& calibration) const {
  return SensorStream(
      std::make_unique<SensorStream::Call>(view().session, ToMessage(calibration, view().world)));
}

RobotStateStream World::StreamRobotStates(const std::string& robot,
                                          const std::vector<std::string>& variables) const {
  v1::RobotStatesHeader header;
  header.set_world(view().world);
  header.set_robot(robot);
  header.mutable_variables()->Assign(variables.begin(), variables.end());
  return RobotStateStream(
      std::make_unique<RobotStateStream::Call>(view().session, std::move(header)));
}

std::vector<Sensor> World::Sensors() const {
  v1::ListSensorsRequest request;
  request.set_world(view().world);
  const v1::ListSensorsResponse reply = internal::Call(
      view(), &v1::PerceptionService::Stub::ListSensors, &client::Connection::perception, request);
  std::vector<Sensor> sensors;
  for (const v1::Sensor& sensor : reply.sensors()) sensors.push_back(FromMessage(sensor));
  return sensors;
}

Eigen::Isometry3d World::SetSensorPose(const std::string& sensor,
                                       const std::optional<Eigen::Isometry3d>& X_WS) const {
  v1::SetSensorPoseRequest request;
  request.set_world(view().world);
  request.set_sensor(sensor);
  if (X_WS) {
    *request.mutable_x_world_sensor() = internal::ToMessage(*X_WS, "X_WS");
  } else {
    request.set_use_estimate(true);
  }
  return internal::FromMessage(internal::Call(view(), &v1::PerceptionService::Stub::SetSensorPose,
                                              &client::Connection::perception, request)
                                   .x_world_sensor());
}

}  // namespace cwm::CWM_API
