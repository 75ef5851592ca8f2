#include "tests/benchmarks/live/real_frames.h"

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "clients/formats/depth_image.h"
#include "clients/formats/frame_sequence.h"
#include "tests/support/outside_data.h"

namespace cwm::benchmarks {
namespace {

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Frames of 16 bits in millimetres; empty if a file cannot be read or is of another kind.
std::vector<RecordedFrame> ReadFolder(const std::string& folder, double rate_hz) {
  const std::string camera_file = formats::FindCameraFile(folder);
  const auto camera = formats::ParseDepthCamera(BytesOf(camera_file), camera_file);
  const auto sequence = formats::ReadFrameFolder(folder);
  if (!camera.ok() || !sequence.ok()) return {};
  std::vector<RecordedFrame> frames;
  for (const formats::SequenceFrame& file : sequence->frames) {
    auto image = formats::ReadDepthImage(BytesOf(file.path), file.path);
    if (!image.ok() || image->type != formats::Scalar::kU16) return {};
    RecordedFrame& frame = frames.emplace_back();
    frame.stamp_s = static_cast<double>(frames.size() - 1) / rate_hz;
    frame.pinhole = {camera->fx_px, camera->fy_px, camera->cx_px, camera->cy_px};
    frame.width = static_cast<int>(image->width);
    frame.height = static_cast<int>(image->height);
    frame.depth = std::move(image->bytes);
    if (!file.x_world_sensor) continue;
    const auto& [position_m, orientation] = *file.x_world_sensor;
    frame.X_WC =
        MakePose({position_m[0], position_m[1], position_m[2]},
                 Quaternion(orientation[3], orientation[0], orientation[1], orientation[2]));
  }
  return frames;
}

}  // namespace

std::vector<RecordedFrame> ReadStaticFrames() {
  const auto folder = cwm::testing::OutsideData("real/xtion_static");
  return folder ? ReadFolder(*folder, 30) : std::vector<RecordedFrame>();
}

std::vector<RecordedFrame> ReadMovingFrames() {
  const auto folder = cwm::testing::OutsideData("depth_sequence");
  if (!folder) return {};
  Vector3 gravity = -Vector3::UnitZ();
  std::istringstream(BytesOf(*folder + "/gravity-direction.txt")) >> gravity.x() >> gravity.y() >>
      gravity.z();
  const Pose upright =
      MakePose(Vector3::Zero(), Quaternion::FromTwoVectors(-gravity, Vector3::UnitZ()));
  std::vector<RecordedFrame> frames = ReadFolder(*folder, 15);
  for (RecordedFrame& frame : frames) frame.X_WC = upright * frame.X_WC;
  return frames;
}

}  // namespace cwm::benchmarks
