// Things that lie on their support touch it and do not sink into it: what the noise leaves open
// about a lying cup, that tells.
#pragma once

#include <optional>
#include <vector>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

// Whether this is a sphere, or a cylinder or cone that does not stand upright (upright ones end at
// the ground whatever their length), over a known ground.
bool MayLie(const ShapeFit& fit, const FitContext& context);

// The shape nearest to a finished fit that may lie, in standard deviations of its parameters, that
// touches the ground with those ends of its seen length that sink into it or are near it within
// their uncertainty; with its own inliers and covariance. Nothing when it still sinks, or fewer
// than min_inliers points agree with it.
std::optional<ShapeFit> RestOnGround(const ShapeFit& fit, const FitContext& context,
                                     const std::vector<char>& available);

}  // namespace cwm::perception
