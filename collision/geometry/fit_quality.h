// How well a fitted shape explains its points.
#pragma once

#include <optional>
#include <vector>

namespace cwm {

struct FitQuality {
  double rms_m = 0;           // of the inliers' orthogonal residuals
  double max_residual_m = 0;  // worst inlier
  int inlier_count = 0;       // points explained
  double inlier_ratio = 0;    // of the points of the object, 0..1
  double observed_fraction =
      0;  // share of the solid's surface (a support: its top face) that points cover, 0..1
  // One standard deviation of each coefficient, in the order of Coefficients() in coefficients.h; of
  // a box, which has none, of its three sizes. 0 where held, or where an end was not seen; empty
  // where unknown.
  std::vector<double> parameter_sigma;

  friend bool operator==(const FitQuality&, const FitQuality&) = default;
};

}  // namespace cwm
