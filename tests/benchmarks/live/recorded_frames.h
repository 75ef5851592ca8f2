// Depth frames in memory, as a client sends them: rendered or read before a measurement begins.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cwm/v1/perception.pb.h"
#include "perception/cloud/pinhole.h"
#include "perception/simulation/sequence_renderer.h"

namespace cwm::benchmarks {

// chosen: depths are sent as most depth cameras send them.
inline constexpr double kDepthUnit_m = 0.001;

struct RecordedFrame {
  double stamp_s = 0;
  perception::Pinhole pinhole = {};
  int width = 0;
  int height = 0;
  Pose X_WC = Pose::Identity();
  std::string depth = {};  // row-major U16 of kDepthUnit_m, little-endian; 0: no return

  std::uint16_t at(std::size_t pixel) const {
    const auto byte = [&](std::size_t i) {
      return static_cast<unsigned>(static_cast<unsigned char>(depth[2 * pixel + i]));
    };
    return static_cast<std::uint16_t>(byte(0) | byte(1) << 8U);
  }
};

// A frame with the truth of its moment.
struct TrueFrame {
  RecordedFrame frame = {};
  std::vector<perception::ObjectTruth> objects = {};   // of the script's scene
  std::vector<std::vector<double>> joint_values = {};  // by robot
  std::int64_t hand_pixels = 0;
  std::int64_t robot_pixels = 0;
  // By pixel, see perception::SequenceFrame; empty unless asked for.
  std::vector<std::int32_t> bodies = {};
};

// Renders the frames [first, first + count) of a sensor of the renderer's script, on all cores.
std::vector<TrueFrame> RenderFrames(const perception::SequenceRenderer& renderer,
                                    std::size_t sensor, int first, int count,
                                    bool keeps_bodies = false);

// The depths of a frame, rounded to kDepthUnit_m.
std::string EncodeDepths(const std::vector<float>& depth_m);

// The points of all returns, in the world.
std::vector<Eigen::Vector3f> PointsInWorld(const RecordedFrame& frame);
// The point of one pixel, which has a return.
Vector3 PointInWorld(const RecordedFrame& frame, std::size_t pixel);

// How a frame is announced and sent; a pose goes with a frame of a camera that moves.
v1::DepthLayout LayoutOf(const RecordedFrame& frame);
v1::SensorFrame MessageOf(const RecordedFrame& frame, bool has_pose);
void SetStamp(double stamp_s, google::protobuf::Timestamp* out);

}  // namespace cwm::benchmarks
