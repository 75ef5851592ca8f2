// A depth camera that stands still before a simulated scene.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "perception/live/sensor_view.h"
#include "perception/simulation/frame_errors.h"
#include "perception/simulation/range_image.h"
#include "tests/perception/live/known_scene.h"

namespace cwm::perception {

// The camera with a quarter of the pixels and the same field of view.
inline PinholeCamera Halved(PinholeCamera camera) {
  camera.width /= 2;
  camera.height /= 2;
  camera.focal_px /= 2;
  camera.center_x_px = (camera.center_x_px - 0.5) / 2;
  camera.center_y_px = (camera.center_y_px - 0.5) / 2;
  return camera;
}

class StillSensor {
 public:
  StillSensor(SimulatedScene its_scene, const PinholeCamera& its_camera)
      : scene(std::move(its_scene)),
        camera(its_camera),
        device_(DrawDeviceErrors(SensorNoise(), its_camera, 11)),
        view("sensor", CameraOf(its_camera), SensorNoise()) {
    Change();
  }

  // The scene was changed: renders it again.
  void Change() {
    const RangeImage image = Render(scene, camera);
    returns_ = {.width = camera.width, .height = camera.height, .pixels = {}};
    returns_.pixels.resize(image.pixels.size());
    ComputeReturns(scene, image, camera, device_, 0, camera.height, returns_);
  }

  std::shared_ptr<DepthImage> Measure() {
    MeasuredDepth measured = DrawFrame(returns_, device_.noise, 1000 + frame_);
    auto image = std::make_shared<DepthImage>();
    image->width = measured.width;
    image->height = measured.height;
    image->depth_m = std::move(measured.depth_m);
    return image;
  }

  FrameEvidence Observe(std::shared_ptr<const DepthImage> image, std::span<const KnownBody> bodies,
                        const RobotMask& robots = {}) {
    const Stamp stamp(std::chrono::milliseconds(33 * ++frame_));
    return view.Observe({stamp, camera.X_WC, std::move(image)}, bodies, robots);
  }
  FrameEvidence Observe(std::span<const KnownBody> bodies, const RobotMask& robots = {}) {
    return Observe(Measure(), bodies, robots);
  }

  // Observes frames of the scene as it is.
  FrameEvidence Rest(int frames, std::span<const KnownBody> bodies) {
    FrameEvidence evidence;
    for (int i = 0; i < frames; ++i) evidence = Observe(bodies);
    return evidence;
  }

  SimulatedScene scene;
  PinholeCamera camera;

 private:
  DeviceErrors device_;
  DeviceReturns returns_;
  std::int64_t frame_ = 0;

 public:
  SensorView view;
};

inline int HotBlocks(const FrameEvidence& evidence) {
  int hot = 0;
  for (const std::uint8_t block : evidence.classes->hot_blocks) hot += block;
  return hot;
}

}  // namespace cwm::perception
