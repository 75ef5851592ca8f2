#include "perception/live/expected_gates.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::perception {
namespace {

constexpr float kNoDepth_m = std::numeric_limits<float>::infinity();
constexpr float kMinGate_m = 1e-6F;  // a gate never holds 0, which is no return

// Joins `of` into the extrema of the values `offset` places before, for places in [begin, end).
void Join(const float* of, int begin, int end, int offset, float* low, float* high) {
  for (int u = begin; u < end; ++u) {
    low[u] = std::min(low[u], of[u + offset]);
    high[u] = std::max(high[u], of[u + offset]);
  }
}

}  // namespace

ExpectedGates::ExpectedGates(int width, int height)
    : width_(width),
      height_(height),
      low_m_(static_cast<std::size_t>(width) * height, kNoDepth_m),
      high_m_(low_m_),
      row_low_m_(low_m_),
      row_high_m_(low_m_) {}

int ExpectedGates::MovingRadius_px(double sigma_px) {
  const int blur_and_error = kStillRadius_px + static_cast<int>(std::ceil(2 * sigma_px));
  return std::clamp(blur_and_error, kMinMovingRadius_px, kMaxMovingRadius_px);
}

void ExpectedGates::Refresh(const PixelRectangle& changed, const std::vector<float>& expected_m,
                            const DepthNoise& noise, bool is_moving, int radius) {
  const PixelRectangle result = Grown(changed, radius, width_, height_);
  const PixelRectangle read = Grown(result, radius, width_, height_);
  const auto at = [&](int v) { return static_cast<std::size_t>(v) * width_; };
  for (int v = read.v_begin; v < read.v_end; ++v) {
    const float* const row = expected_m.data() + at(v);
    float* const low = row_low_m_.data() + at(v);
    float* const high = row_high_m_.data() + at(v);
    std::copy(row + result.u_begin, row + result.u_end, low + result.u_begin);
    std::copy(row + result.u_begin, row + result.u_end, high + result.u_begin);
    for (int offset = -radius; offset <= radius; ++offset) {
      Join(row, std::max(result.u_begin, -offset), std::min(result.u_end, width_ - offset), offset,
           low, high);
    }
  }
  for (int v = result.v_begin; v < result.v_end; ++v) {
    float* const low = low_m_.data() + at(v);
    float* const high = high_m_.data() + at(v);
    std::copy(row_low_m_.data() + at(v) + result.u_begin, row_low_m_.data() + at(v) + result.u_end,
              low + result.u_begin);
    std::copy(row_high_m_.data() + at(v) + result.u_begin,
              row_high_m_.data() + at(v) + result.u_end, high + result.u_begin);
    for (int beside = std::max(0, v - radius); beside < std::min(height_, v + radius + 1);
         ++beside) {
      const float* const beside_low = row_low_m_.data() + at(beside);
      const float* const beside_high = row_high_m_.data() + at(beside);
      for (int u = result.u_begin; u < result.u_end; ++u) {
        low[u] = std::min(low[u], beside_low[u]);
        high[u] = std::max(high[u], beside_high[u]);
      }
    }
    const auto tolerance_m = [&](float depth_m) {
      return is_moving ? noise.ExplainedWhileMoving_m(depth_m) : noise.Explained_m(depth_m);
    };
    for (int u = result.u_begin; u < result.u_end; ++u) {
      if (low[u] == kNoDepth_m) continue;
      low[u] = std::max(low[u] - tolerance_m(low[u]), kMinGate_m);
      if (high[u] != kNoDepth_m) high[u] += tolerance_m(high[u]);
    }
  }
}

}  // namespace cwm::perception
