#include "perception/live/mean_view.h"

#include <cmath>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {

std::vector<float> MeanAtRest(std::span<const StillFrame> frames, const DepthCamera& camera,
                              const SensorNoise& noise) {
  std::vector<float> mean_m(camera.pixel_count(), 0);
  const std::size_t half = frames.size() / 2;
  for (std::size_t i = 0; i < mean_m.size(); ++i) {
    float first_m = 0;
    float last_m = 0;
    bool is_at_rest = true;
    for (std::size_t k = 0; k < frames.size() && is_at_rest; ++k) {
      const float z = frames[k].image->depth_m[i];
      const PixelClass pixel = frames[k].classes->pixels[i];
      is_at_rest = z >= camera.least_range_m && z <= camera.greatest_range_m &&
                   (pixel == PixelClass::kConsistent || pixel == PixelClass::kNearer ||
                    pixel == PixelClass::kFarther);
      (k < half ? first_m : last_m) += z;
    }
    if (!is_at_rest) continue;
    const float before_m = first_m / static_cast<float>(half);
    const float after_m = last_m / static_cast<float>(frames.size() - half);
    const double sigma_m =
        noise.AxialSigma_m(before_m) * std::sqrt(2.0 / static_cast<double>(half));
    if (std::abs(before_m - after_m) > kGate_sigma * sigma_m) continue;
    mean_m[i] = (first_m + last_m) / static_cast<float>(frames.size());
  }
  return mean_m;
}

}  // namespace cwm::perception
