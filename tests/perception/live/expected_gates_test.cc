#include "perception/live/expected_gates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

constexpr float kNothing_m = std::numeric_limits<float>::infinity();
constexpr int kWidth = 157;  // no multiple of any register, nor of the columns joined at a time
constexpr int kHeight = 41;

// The gates of a pixel by their definition.
void ExpectGates(const ExpectedGates& gates, const std::vector<float>& expected_m,
                 const DepthNoise& noise, bool is_moving, int radius_px, int u, int v) {
  const auto tolerance_m = [&](float depth_m) {
    return is_moving ? noise.ExplainedWhileMoving_m(depth_m) : noise.Explained_m(depth_m);
  };
  float low = kNothing_m;
  float high = 0;
  for (int row = std::max(0, v - radius_px); row <= std::min(kHeight - 1, v + radius_px); ++row) {
    for (int column = std::max(0, u - radius_px); column <= std::min(kWidth - 1, u + radius_px);
         ++column) {
      const float depth_m = expected_m[static_cast<std::size_t>(row) * kWidth + column];
      low = std::min(low, depth_m);
      high = std::max(high, depth_m);
    }
  }
  if (low != kNothing_m) low -= tolerance_m(low);
  if (high != kNothing_m) high += tolerance_m(high);
  const std::size_t i = static_cast<std::size_t>(v) * kWidth + u;
  ASSERT_EQ(gates.low_m()[i], low) << "at " << u << ", " << v << ", radius " << radius_px;
  ASSERT_EQ(gates.high_m()[i], high) << "at " << u << ", " << v << ", radius " << radius_px;
}

TEST(ExpectedGates, HoldTheDepthsOfEachNeighbourhood) {
  DepthCamera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  const DepthNoise noise(camera, SensorNoise());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> depth_m(0.5F, 3);
  std::vector<float> expected_m(camera.pixel_count());
  for (float& each : expected_m) each = random() % 50 == 0 ? kNothing_m : depth_m(random);
  const PixelRectangle whole = {.u_end = kWidth, .v_end = kHeight};
  for (int radius_px = ExpectedGates::kStillRadius_px;
       radius_px <= ExpectedGates::kMaxMovingRadius_px; ++radius_px) {
    const bool is_moving = radius_px >= ExpectedGates::kMinMovingRadius_px;
    ExpectedGates gates(kWidth, kHeight);
    gates.Refresh(whole, expected_m, noise, is_moving, radius_px);
    // A part of the image changes, up to its border.
    const PixelRectangle changed = {.u_begin = 120, .v_begin = 10, .u_end = kWidth, .v_end = 17};
    for (int v = changed.v_begin; v < changed.v_end; ++v) {
      for (int u = changed.u_begin; u < changed.u_end; ++u) {
        expected_m[static_cast<std::size_t>(v) * kWidth + u] = depth_m(random);
      }
    }
    gates.Refresh(changed, expected_m, noise, is_moving, radius_px);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        ExpectGates(gates, expected_m, noise, is_moving, radius_px, u, v);
      }
    }
  }
}

}  // namespace
}  // namespace cwm::perception
