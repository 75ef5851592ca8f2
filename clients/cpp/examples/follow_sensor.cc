// Follows a world with a camera that looks down at a floor, on which a block is pushed.
#include <cwm/client.h>

#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal_px = 280;

// In millimetres: the floor 1 m below the camera, and a block of 10 x 10 x 10 cm on it whose centre
// is at x metres.
std::vector<std::uint16_t> Depths(double x) {
  std::vector<std::uint16_t> depths(kWidth * kHeight, 1000);
  const double scale = kFocal_px / 0.9;  // pixels per metre of the block's top
  const int left = static_cast<int>((x - 0.05) * scale) + kWidth / 2;
  const int half = static_cast<int>(0.05 * scale);
  for (int v = kHeight / 2 - half; v < kHeight / 2 + half; ++v) {
    for (int u = left; u < left + 2 * half; ++u) {
      depths[static_cast<std::size_t>(v * kWidth + u)] = 900;
    }
  }
  return depths;
}

int main() try {
  using Clock = std::chrono::system_clock;
  const cwm::World world = cwm::Connect({.world = "follow_sensor"});
  Eigen::Isometry3d X_WS(Eigen::Translation3d(0, 0, 1));
  X_WS.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();  // it looks down
  cwm::SensorStream stream = world.StreamSensor(
      {.sensor = "overhead",
       .width = kWidth,
       .height = kHeight,
       .pinhole = {kFocal_px, kFocal_px, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0},
       .X_WS = X_WS});
  for (int frame = 0; frame < 90; ++frame) {
    const double x = frame < 60 ? 0 : 0.1;  // it was pushed by 10 cm
    const cwm::FrameResult result = stream.Process(Depths(x), {.stamp = Clock::now()});
    if (result.fate != cwm::FrameFate::kProcessed) {
      std::printf("frame %lld: %s\n", static_cast<long long>(result.frame), result.reason.c_str());
    }
    for (const std::string& name : result.changes.added) std::printf("added %s\n", name.c_str());
    for (const std::string& name : result.changes.moved) std::printf("moved %s\n", name.c_str());
    for (const std::string& name : result.changes.removed) {
      std::printf("removed %s\n", name.c_str());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
  }
  for (const cwm::Sensor& sensor : world.Sensors()) {
    std::printf("%s: %lld frames, latency %.1f ms\n", sensor.name.c_str(),
                static_cast<long long>(sensor.processed_count), sensor.latency_p50_ms);
  }
} catch (const cwm::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
