#include "perception/live/depth_noise.h"

#include <cmath>

namespace cwm::perception {
namespace {

// chosen: sigma grows by at most 1 % from one entry to the next within a camera's range.
constexpr double kEntriesPerMetre = 200;
constexpr double kMaxEntries = 16384;
// chosen: a tolerance that is larger by so little tells as much.
constexpr double kPoseErrorStep_m = 0.0005;

float ToleranceOf(double axial_m, double shared_m) {
  return static_cast<float>(
      std::max(kExplainedWithin_m, kDifference_sigma * std::hypot(axial_m, shared_m)));
}

}  // namespace

DepthNoise::DepthNoise(const DepthCamera& camera, const SensorNoise& noise) : noise_(noise) {
  noise_.image_width_px = std::max(1, camera.width);
  const double range_m = std::max(0.1, static_cast<double>(camera.greatest_range_m));
  const auto entries =
      static_cast<std::size_t>(std::clamp(range_m * kEntriesPerMetre, 2.0, kMaxEntries));
  per_m_ = static_cast<float>(static_cast<double>(entries) / range_m);
  table_.reserve(entries);
  for (std::size_t i = 0; i < entries; ++i) {
    const double depth_m = (static_cast<double>(i) + 0.5) / per_m_;
    const double axial_m = noise_.AxialSigma_m(depth_m);
    table_.push_back({.axial_m = static_cast<float>(axial_m),
                      .lateral_px = static_cast<float>(noise_.LateralSigma_m(depth_m) *
                                                       camera.pinhole.focal_u_px / depth_m),
                      .explained_m = ToleranceOf(axial_m, noise_.WarpSigma_m())});
  }
  SetPoseError(kRegistration_m);
}

void DepthNoise::SetPoseError(double sigma_m) {
  const double rounded_m = std::ceil(sigma_m / kPoseErrorStep_m) * kPoseErrorStep_m;
  if (rounded_m == pose_error_m_) return;
  pose_error_m_ = rounded_m;
  const double shared_m = std::hypot(noise_.WarpSigma_m(), rounded_m);
  for (Entry& entry : table_) entry.explained_moving_m = ToleranceOf(entry.axial_m, shared_m);
}

}  // namespace cwm::perception
