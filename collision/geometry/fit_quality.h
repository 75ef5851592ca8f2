// The quality of the fit of a shape to its points.
#pragma once

#include <optional>
#include <vector>

namespace cwm {

struct FitQuality {
  double rms_m = 0;           // root mean square of the inliers' orthogonal residuals
  double max_residual_m = 0;  // largest residual of an inlier
  int inlier_count = 0;       // number of points that the shape explains
  double inlier_ratio = 0;    // share of the object's points that are inliers, 0..1
  double observed_fraction =
      0;  // share of the solid's surface (of a support: its top face) that points cover, 0..1
  // One standard deviation of each coefficient, in the order of Coefficients() in coefficients.h;
  // of the three sizes for a box, which has no coefficients. 0 for a parameter that was held fixed
  // or whose end was not seen; empty if unknown.
  std::vector<double> parameter_sigma;

  friend bool operator==(const FitQuality&, const FitQuality&) = default;
};

}  // namespace cwm
