#include "perception/live/expected_gates.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::perception {
namespace {

constexpr float kNoDepth_m = std::numeric_limits<float>::infinity();
constexpr float kMinGate_m = 1e-6F;  // a gate never holds 0, which is no return

// chosen: columns are joined in strips of this width, whose rows fit into a core's cache.
constexpr int kStrip_px = 128;

// Joins each line with the `window` - 1 lines after it, in place; the last `window` - 1 lines are
// of no use then. The lines follow each other. Each step doubles the lines that a line holds: van
// Herk's three comparisons by value could not be made for many values at once.
template <class Join>
void JoinWindows(float* lines, std::size_t line_count, std::size_t line_size, std::size_t window,
                 const Join& join) {
  const auto join_after = [&](std::size_t step) {
    line_count -= step;
    const float* const others = lines + step * line_size;
    for (std::size_t i = 0; i < line_count * line_size; ++i) lines[i] = join(lines[i], others[i]);
  };
  std::size_t held = 1;
  for (; 2 * held <= window; held *= 2) join_after(held);
  if (held < window) join_after(window - held);
}

}  // namespace

ExpectedGates::ExpectedGates(int width, int height)
    : width_(width),
      height_(height),
      low_m_(static_cast<std::size_t>(width) * height, kNoDepth_m),
      high_m_(low_m_),
      rows_(low_m_.size()) {}

int ExpectedGates::MovingRadius_px(double sigma_px) {
  const int blur_and_error = kStillRadius_px + static_cast<int>(std::ceil(2 * sigma_px));
  return std::clamp(blur_and_error, kMinMovingRadius_px, kMaxMovingRadius_px);
}

// Joins the values of `from` within `radius` pixels of each pixel of a rectangle, along rows into
// `rows`, and then along columns into `to`. Beyond the image all is `neutral`.
template <class Join>
void ExpectedGates::JoinAround(const PixelRectangle& pixels, int radius, const float* from,
                               float neutral, const Join& join, float* to) {
  const PixelRectangle read = Grown(pixels, radius, width_, height_);
  const auto at = [&](int u, int v) { return static_cast<std::size_t>(v) * width_ + u; };
  const std::size_t more = 2 * static_cast<std::size_t>(radius);  // lines that no pixel is in
  const std::size_t window = more + 1;
  const auto width =
      static_cast<std::size_t>(pixels.u_end) - static_cast<std::size_t>(pixels.u_begin);
  lines_.resize(width + more);
  for (int v = read.v_begin; v < read.v_end; ++v) {
    std::ranges::fill(lines_, neutral);
    std::copy(from + at(read.u_begin, v), from + at(read.u_end, v),
              lines_.begin() + (read.u_begin - pixels.u_begin + radius));
    JoinWindows(lines_.data(), lines_.size(), 1, window, join);
    std::copy_n(lines_.begin(), width, rows_.begin() + at(pixels.u_begin, v));
  }
  const std::size_t height =
      static_cast<std::size_t>(pixels.v_end) - static_cast<std::size_t>(pixels.v_begin);
  for (int u = pixels.u_begin; u < pixels.u_end; u += kStrip_px) {
    const int strip = std::min(kStrip_px, pixels.u_end - u);
    const auto line_of = [&](int v) {
      return lines_.begin() + std::ptrdiff_t{strip} * (v - pixels.v_begin + radius);
    };
    lines_.assign((height + more) * strip, neutral);
    for (int v = read.v_begin; v < read.v_end; ++v) {
      std::copy_n(rows_.begin() + at(u, v), strip, line_of(v));
    }
    JoinWindows(lines_.data(), height + more, static_cast<std::size_t>(strip), window, join);
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      std::copy_n(line_of(v - radius), strip, to + at(u, v));
    }
  }
}

void ExpectedGates::Refresh(const PixelRectangle& changed, const std::vector<float>& expected_m,
                            const DepthNoise& noise, bool is_moving, int radius) {
  const PixelRectangle result = Grown(changed, radius, width_, height_);
  if (result.empty()) return;
  JoinAround(
      result, radius, expected_m.data(), kNoDepth_m,
      [](float a, float b) { return std::min(a, b); }, low_m_.data());
  JoinAround(
      result, radius, expected_m.data(), -kNoDepth_m,
      [](float a, float b) { return std::max(a, b); }, high_m_.data());
  const auto tolerance_m = [&](float depth_m) {
    return is_moving ? noise.ExplainedWhileMoving_m(depth_m) : noise.Explained_m(depth_m);
  };
  for (int v = result.v_begin; v < result.v_end; ++v) {
    float* const low = low_m_.data() + static_cast<std::size_t>(v) * width_;
    float* const high = high_m_.data() + static_cast<std::size_t>(v) * width_;
    for (int u = result.u_begin; u < result.u_end; ++u) {
      if (low[u] == kNoDepth_m) continue;
      low[u] = std::max(low[u] - tolerance_m(low[u]), kMinGate_m);
      if (high[u] != kNoDepth_m) high[u] += tolerance_m(high[u]);
    }
  }
}

}  // namespace cwm::perception
