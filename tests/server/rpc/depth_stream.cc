#include "tests/server/rpc/depth_stream.h"

#include <cmath>
#include <utility>

namespace cwm::server {

v1::SensorCalibration SmallCamera(const std::string& sensor, int width_px, int height_px) {
  v1::SensorCalibration calibration;
  calibration.set_sensor(sensor);
  // The optical axis z along x, the image's x along -y, its y along -z.
  v1::Pose& pose = *calibration.mutable_x_world_sensor();
  pose.set_tz_m(1);
  pose.set_qx(-0.5);
  pose.set_qy(0.5);
  pose.set_qz(-0.5);
  pose.set_qw(0.5);
  v1::DepthLayout& depth = *calibration.mutable_depth();
  depth.set_type(v1::DEPTH_TYPE_F32);
  depth.set_width(width_px);
  depth.set_height(height_px);
  depth.mutable_pinhole()->set_fx_px(width_px);
  depth.mutable_pinhole()->set_fy_px(width_px);
  depth.mutable_pinhole()->set_cx_px(0.5 * (width_px - 1));
  depth.mutable_pinhole()->set_cy_px(0.5 * (height_px - 1));
  return calibration;
}

v1::SensorFrame WallFrame(const v1::SensorCalibration& calibration, float depth_m, double stamp_s) {
  v1::SensorFrame frame;
  const double seconds = std::floor(stamp_s);
  frame.mutable_frame_stamp()->set_seconds(static_cast<std::int64_t>(seconds));
  frame.mutable_frame_stamp()->set_nanos(static_cast<std::int32_t>(1e9 * (stamp_s - seconds)));
  const auto pixels =
      static_cast<std::size_t>(calibration.depth().width()) * calibration.depth().height();
  const std::vector<float> depths(pixels, depth_m);
  frame.set_depth(reinterpret_cast<const char*>(depths.data()), sizeof(float) * pixels);
  return frame;
}

bool DepthStream::Send(const v1::SensorCalibration& calibration) {
  v1::StreamCloudsRequest request;
  *request.mutable_calibration() = calibration;
  return stream_->Write(request);
}

bool DepthStream::Send(const v1::SensorFrame& frame) {
  v1::StreamCloudsRequest request;
  *request.mutable_frame() = frame;
  return stream_->Write(request);
}

std::optional<v1::StreamCloudsResponse> DepthStream::Next() {
  v1::StreamCloudsResponse response;
  if (!stream_->Read(&response)) return std::nullopt;
  return response;
}

v1::StreamCloudsResponse DepthStream::MustProcess(const v1::SensorFrame& frame) {
  EXPECT_TRUE(Send(frame));
  const auto answer = Next();
  EXPECT_TRUE(answer.has_value());
  if (!answer.has_value()) return {};
  EXPECT_EQ(answer->fate(), v1::FRAME_FATE_PROCESSED)
      << answer->reason() << ": " << answer->message();
  return *answer;
}

void DepthStream::WritesDone() {
  if (!std::exchange(is_done_, true)) stream_->WritesDone();
}

grpc::Status DepthStream::Finish() {
  WritesDone();
  while (Next().has_value()) {
  }
  return stream_->Finish();
}

}  // namespace cwm::server
