// Makes lying shapes touch their support without sinking into it, which constrains what the noise
// leaves open about a lying cup.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

// True if the fit is a sphere, or a cylinder or cone that is not upright, seen from outside, over a
// known ground. Upright ones end at the ground whatever their length.
bool CanRestOnGround(const ShapeFit& fit, const FitContext& context);

// Returns the shape nearest to a finished fit that may lie, in standard deviations of its
// parameters, that touches the ground with those ends of its seen length that sink into it or are
// near it within their uncertainty; with its own inliers and covariance. Empty if it still sinks,
// or if fewer than min_inliers points agree with it.
std::optional<ShapeFit> RestOnGround(const ShapeFit& fit, const FitContext& context,
                                     const std::vector<char>& available);

}  // namespace cwm::perception
