// The local planes of what a sensor sees at rest.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/live/mean_view.h"
#include "perception/live/pixel_rays.h"

namespace cwm::perception {

struct ViewPlane {
  Vector3 p_W = Vector3::Zero();
  Vector3 normal_W = Vector3::UnitZ();  // to the sensor
  double depth_m = 0;
  double normal_variance = 0;  // of each component across the normal, by noise and warp
};

// The planes about pixels of a view.
class ViewPlanes {
 public:
  explicit ViewPlanes(const MeanView& view)
      : view_(view),
        rays_(view.camera, view.X_WC),
        warp_m_(view.noise.WarpSigma_m()),
        places_(view.camera.pixel_count(), kUnknown) {}

  float depth_m(int u, int v) const {
    return view_.depth_m[static_cast<std::size_t>(v) * view_.camera.width + u];
  }

  // The plane of least squares about the pixel; null at edges and where returns are missing.
  // Valid until the next call.
  const ViewPlane* At(int u, int v) {
    std::int32_t& place = places_[static_cast<std::size_t>(v) * view_.camera.width + u];
    if (place == kUnknown) {
      place = kNone;
      if (const auto plane = Fit(u, v)) {
        place = static_cast<std::int32_t>(planes_.size());
        planes_.push_back(*plane);
      }
    }
    return place == kNone ? nullptr : &planes_[static_cast<std::size_t>(place)];
  }

  // The variance along the normal of the errors that a patch shares, and of a local plane's own.
  double SharedVariance_m2() const { return warp_m_ * warp_m_; }
  double OwnVariance_m2(double depth_m) const {
    const double sigma_m = view_.noise.AxialSigma_m(depth_m);
    return sigma_m * sigma_m / 2;  // derived: the mean of some frames, of neighbours that are alike
  }

  const MeanView& view() const { return view_; }

 private:
  static constexpr std::int32_t kUnknown = -1, kNone = -2;

  std::optional<ViewPlane> Fit(int u, int v) const;
  std::optional<ViewPlane> FitWithin(int u, int v, double window_m) const;

  const MeanView& view_;
  PixelRays rays_;
  double warp_m_;
  std::vector<std::int32_t> places_;  // per pixel, in planes_
  std::vector<ViewPlane> planes_;
};

}  // namespace cwm::perception
