// The uncertainty of a fitted part's surface.
#pragma once

#include "collision/geometry/hybrid_model.h"

namespace cwm {

// An upper bound of the standard deviation, in metres, of any point of the part's surface: the sum
// of the displacements that the parameters' deviations can cause. It holds for any correlation,
// since the deviation of a sum is at most the sum of the deviations. s is
// FitQuality::parameter_sigma, and |s| the root of the sum of squares over a vector's coordinates:
//   sphere      |s_centre| + s_radius
//   cylinder    |s_q| + R |s_axis| + s_radius            R: from q to the rim, its farthest point
//   cone        s_flank + L (|s_axis| + s_half_angle)    L: from the apex to the farther rim;
//               s_flank, the displacement of the flank by the apex, is the lesser of |s_apex| and
//               the sum over the coordinates k of s_k (|a_k| sin(half angle) + sqrt(1 - a_k^2)),
//               with the axis a
//   plate       s_d + D |s_normal|                       D: the diagonal of its outline's bounds
//   box         |s_sizes|                                one face may have moved by all of it
// For other shapes, and if the deviations are unknown, the fit's rms_m: the scatter of the points
// is all that is known. 0 without a fit. The position of an end that was not seen is not included.
//
// The plate's bound holds because a plane is known near its points at least as well as at the
// origin (s_d), and no point of the plate is farther than D from them.
double SurfaceSigma_m(const ShapePart& part);

}  // namespace cwm
