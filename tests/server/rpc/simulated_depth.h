// The kitchen counter as a depth camera of one device sees it, frame after frame.
#pragma once

#include <cstdint>
#include <string>

#include "cwm/v1/perception.pb.h"
#include "perception/simulation/frame_errors.h"
#include "perception/simulation/range_image.h"
#include "perception/simulation/scenes.h"

namespace cwm::server {

inline v1::DepthLayout LayoutOf(const perception::PinholeCamera& camera) {
  v1::DepthLayout layout;
  layout.set_type(v1::DEPTH_TYPE_F32);
  layout.set_width(camera.width);
  layout.set_height(camera.height);
  layout.mutable_pinhole()->set_fx_px(camera.focal_px);
  layout.mutable_pinhole()->set_fy_px(camera.focal_px);
  layout.mutable_pinhole()->set_cx_px(camera.center_x_px);
  layout.mutable_pinhole()->set_cy_px(camera.center_y_px);
  return layout;
}

class SimulatedDepth {
 public:
  explicit SimulatedDepth(perception::SimulatedScene scene = perception::KitchenCounter())
      : camera_(perception::KitchenCamera()),
        device_(perception::DrawDeviceErrors({}, camera_, 5)) {
    Show(scene);
  }

  // What the camera sees from now on.
  void Show(const perception::SimulatedScene& scene) {
    const perception::RangeImage image = perception::Render(scene, camera_);
    returns_ = {.width = camera_.width, .height = camera_.height, .pixels = {}};
    returns_.pixels.resize(image.pixels.size());
    perception::ComputeReturns(scene, image, camera_, device_, 0, camera_.height, returns_);
  }

  v1::DepthLayout Layout() const { return LayoutOf(camera_); }
  // Float depths, row by row.
  std::string Frame(std::uint64_t seed) const {
    const perception::MeasuredDepth depth = perception::DrawFrame(returns_, device_.noise, seed);
    return {reinterpret_cast<const char*>(depth.depth_m.data()),
            depth.depth_m.size() * sizeof(float)};
  }
  std::int64_t pixel_count() const { return std::int64_t{camera_.width} * camera_.height; }

 private:
  perception::PinholeCamera camera_;
  perception::DeviceErrors device_;
  perception::DeviceReturns returns_;
};

}  // namespace cwm::server
