#include "tests/benchmarks/live/recorded_frames.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

TrueFrame Record(perception::SequenceFrame rendered, bool keeps_bodies) {
  const perception::PinholeCamera& camera = rendered.camera;
  TrueFrame recorded;
  recorded.frame = {.stamp_s = rendered.stamp_s,
                    .pinhole = {.focal_u_px = camera.focal_px,
                                .focal_v_px = camera.focal_px,
                                .center_u_px = camera.center_x_px,
                                .center_v_px = camera.center_y_px},
                    .width = camera.width,
                    .height = camera.height,
                    .X_WC = camera.X_WC,
                    .depth = EncodeDepths(rendered.depth.depth_m)};
  recorded.objects = std::move(rendered.objects);
  recorded.joint_values = std::move(rendered.joint_values);
  recorded.hand_pixels = rendered.hand_pixel_count;
  recorded.robot_pixels = rendered.robot_pixel_count;
  if (keeps_bodies) recorded.bodies = std::move(rendered.depth.object);
  return recorded;
}

}  // namespace

std::vector<TrueFrame> RenderFrames(const perception::SequenceRenderer& renderer,
                                    std::size_t sensor, int first, int count, bool keeps_bodies) {
  std::vector<TrueFrame> frames(static_cast<std::size_t>(std::max(count, 0)));
  std::atomic<std::size_t> next = 0;
  const auto render = [&] {
    for (std::size_t i = next++; i < frames.size(); i = next++) {
      frames[i] = Record(renderer.Render(sensor, first + static_cast<int>(i)), keeps_bodies);
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 1; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
    threads.emplace_back(render);
  }
  render();
  for (std::thread& thread : threads) thread.join();
  return frames;
}

std::string EncodeDepths(const std::vector<float>& depth_m) {
  constexpr double kMaxUnits = 65'534;  // 65535 is no return
  std::string bytes(2 * depth_m.size(), '\0');
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const double units = std::round(depth_m[i] / kDepthUnit_m);
    const auto value =
        units >= 1 && units <= kMaxUnits ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
    bytes[2 * i] = static_cast<char>(value & 0xFFU);
    bytes[2 * i + 1] = static_cast<char>(value >> 8U);
  }
  return bytes;
}

Vector3 PointInWorld(const RecordedFrame& frame, std::size_t pixel) {
  const auto width = static_cast<std::size_t>(frame.width);
  const auto u = static_cast<double>(pixel % width), v = static_cast<double>(pixel / width);
  const double z_m = frame.at(pixel) * kDepthUnit_m;
  return frame.X_WC * Vector3((u - frame.pinhole.center_u_px) * z_m / frame.pinhole.focal_u_px,
                              (v - frame.pinhole.center_v_px) * z_m / frame.pinhole.focal_v_px,
                              z_m);
}

std::vector<Eigen::Vector3f> PointsInWorld(const RecordedFrame& frame) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(frame.depth.size() / 2);
  for (std::size_t pixel = 0; pixel < frame.depth.size() / 2; ++pixel) {
    if (frame.at(pixel) != 0) points.emplace_back(PointInWorld(frame, pixel).cast<float>());
  }
  return points;
}

v1::DepthLayout LayoutOf(const RecordedFrame& frame) {
  v1::DepthLayout layout;
  layout.set_type(v1::DEPTH_TYPE_U16);
  layout.set_width(frame.width);
  layout.set_height(frame.height);
  layout.set_unit_m(kDepthUnit_m);
  v1::Pinhole& pinhole = *layout.mutable_pinhole();
  pinhole.set_fx_px(frame.pinhole.focal_u_px);
  pinhole.set_fy_px(frame.pinhole.focal_v_px);
  pinhole.set_cx_px(frame.pinhole.center_u_px);
  pinhole.set_cy_px(frame.pinhole.center_v_px);
  return layout;
}

void SetStamp(double stamp_s, google::protobuf::Timestamp* out) {
  const auto nanoseconds = static_cast<std::int64_t>(std::llround(stamp_s * 1e9));
  out->set_seconds(nanoseconds / 1'000'000'000);
  out->set_nanos(static_cast<std::int32_t>(nanoseconds % 1'000'000'000));
}

v1::SensorFrame MessageOf(const RecordedFrame& frame, bool has_pose) {
  v1::SensorFrame message;
  SetStamp(frame.stamp_s, message.mutable_frame_stamp());
  if (has_pose) SetPose(frame.X_WC, message.mutable_x_world_sensor());
  message.set_depth(frame.depth);
  return message;
}

}  // namespace cwm::benchmarks
