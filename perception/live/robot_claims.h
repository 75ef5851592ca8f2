// The pixels whose measured points are within a margin of rigid bodies.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/live/depth_image.h"
#include "perception/live/known_body.h"
#include "perception/live/robot_surface.h"

namespace cwm::perception {

// Half open.
struct PixelBounds {
  int u_begin = 0, v_begin = 0, u_end = 0, v_end = 0;

  bool empty() const { return u_begin >= u_end || v_begin >= v_end; }
  void Extend(const PixelBounds& other);
};

// The pixels whose rays may meet a box, nearest_m or more before the camera; empty if none can.
PixelBounds ProjectBox(const Aabb& bounds_L, const Pose& X_CL, const DepthCamera& camera,
                       double nearest_m);

// Known surfaces as a frame should show them; both empty if they are not known.
struct ExpectedSurfaces {
  std::span<const float> depth_m = {};
  std::span<const BodyId> body = {};
  std::span<const BodyId> ignored = {};  // bodies that a robot carries

  // The expected depth; infinite if nothing is known there.
  float At(std::size_t pixel) const;
};

// A surface as a frame may show it.
struct BodyInView {
  const LinkSurface* surface = nullptr;  // not empty
  int link = 0;
  bool is_carried = false;
  Pose X_CL = Pose::Identity();
  Eigen::Matrix3f R_LC = Eigen::Matrix3f::Identity();
  Eigen::Vector3f origin_L = Eigen::Vector3f::Zero();  // of the camera
  float margin_m = 0;
  // The part of the margin that noise calls for: no known surface explains better what is nearer.
  float slack_m = 0;
  PixelBounds bounds = {};  // of the points within the margin

  Eigen::Vector3f InLink(const Eigen::Vector3f& p_C) const { return origin_L + R_LC * p_C; }
};

// The least and greatest depth of each block of kBlock_px pixels; the least is infinite without
// returns.
class BlockDepths {
 public:
  // Covers the blocks that `bounds` touches.
  void Compute(const DepthImage& image, const PixelBounds& bounds);

  struct Range_m {
    float least = 0;
    float greatest = 0;
  };
  const Range_m& at(int column, int row) const {
    return ranges_[static_cast<std::size_t>(row) * columns_ + column];
  }

 private:
  int columns_ = 0;
  std::vector<Range_m> ranges_;
};

// How far measured depths are from a surface, by kGate_sigma of the sensor's noise and warp.
class DepthTolerance {
 public:
  DepthTolerance(const SensorNoise& noise, float greatest_range_m);

  float At_m(float depth_m) const {
    const auto step = static_cast<std::size_t>(depth_m * steps_per_m_);
    return at_steps_m_[std::min(step, at_steps_m_.size() - 1)];
  }

 private:
  static constexpr int kSteps = 256;
  float steps_per_m_ = 0;
  std::array<float, kSteps> at_steps_m_ = {};  // at the far end of each step
};

// A frame whose pixels are to be claimed.
struct ClaimFrame {
  const DepthCamera* camera = nullptr;
  const DepthImage* image = nullptr;
  const BlockDepths* blocks = nullptr;
  DepthTolerance tolerance;
  ExpectedSurfaces expected = {};

  Eigen::Vector3f Point(int u, int v, float depth_m) const;
  // True if a point is where a known surface is, up to the sensor's noise.
  bool IsExpected(std::size_t pixel, float depth_m) const;
};

// Claims for the bodies, which are all carried or all links, the pixels that have no class yet. Of
// pixels that carried bodies have claimed and a link claims too, the nearer one gets each.
// `carried` are all carried bodies.
void ClaimPixels(const ClaimFrame& frame, std::span<const BodyInView> bodies,
                 std::span<const BodyInView> carried, std::span<std::uint8_t> pixels);

// Classes as mixed the pixels without a class within `margin_m` of the body that no known surface
// explains.
void ClaimAsMixed(const ClaimFrame& frame, const BodyInView& body, float margin_m,
                  const PixelBounds& bounds, std::span<std::uint8_t> pixels);

}  // namespace cwm::perception
