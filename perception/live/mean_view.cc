#include "perception/live/mean_view.h"

#include <algorithm>
#include <cmath>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

bool IsOfRobot(PixelClass pixel) {
  return pixel == PixelClass::kRobot || pixel == PixelClass::kCarried ||
         pixel == PixelClass::kMixed || pixel == PixelClass::kHidden;
}

// The returns of a pixel in one half of the frames that agree with its median.
struct HalfOfFrames {
  std::size_t frames = 0;
  int returns = 0;
  float sum_m = 0;

  void Add(float depth_m) {
    ++returns;
    sum_m += depth_m;
  }
  bool IsSeen() const { return returns > 0 && returns >= kMajority * static_cast<double>(frames); }
  float mean_m() const { return sum_m / static_cast<float>(returns); }
};

}  // namespace

std::vector<float> MeanAtRest(std::span<const StillFrame> frames, const DepthCamera& camera,
                              const SensorNoise& noise) {
  std::vector<float> mean_m(camera.pixel_count(), 0);
  const std::size_t half = frames.size() / 2;
  std::vector<float> sorted_m;
  for (std::size_t i = 0; i < mean_m.size(); ++i) {
    const auto is_return = [&](const StillFrame& frame) {
      const float z = frame.image->depth_m[i];
      return frame.classes->pixels[i] != PixelClass::kMissing && z >= camera.least_range_m &&
             z <= camera.greatest_range_m;
    };
    sorted_m.clear();
    bool is_of_robot = false;
    for (const StillFrame& frame : frames) {
      is_of_robot |= IsOfRobot(frame.classes->pixels[i]);
      if (is_return(frame)) sorted_m.push_back(frame.image->depth_m[i]);
    }
    if (is_of_robot || sorted_m.empty()) continue;
    const auto middle = sorted_m.begin() + static_cast<std::ptrdiff_t>(sorted_m.size() / 2);
    std::ranges::nth_element(sorted_m, middle);
    const float median_m = *middle;
    const double sigma_m = noise.AxialSigma_m(median_m);
    HalfOfFrames first{.frames = half};
    HalfOfFrames last{.frames = frames.size() - half};
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const float z = frames[k].image->depth_m[i];
      if (!is_return(frames[k]) || std::abs(z - median_m) > kGate_sigma * sigma_m) continue;
      (k < half ? first : last).Add(z);
    }
    if (!first.IsSeen() || !last.IsSeen()) continue;
    const double apart_sigma_m = sigma_m * std::sqrt(1.0 / first.returns + 1.0 / last.returns);
    if (std::abs(first.mean_m() - last.mean_m()) > kGate_sigma * apart_sigma_m) continue;
    mean_m[i] = (first.sum_m + last.sum_m) / static_cast<float>(first.returns + last.returns);
  }
  return mean_m;
}

}  // namespace cwm::perception
