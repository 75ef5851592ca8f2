// How far the surface of a fitted part may be from where its fit has it.
#pragma once

#include "collision/geometry/hybrid_model.h"

namespace cwm {

// A bound on the standard deviation, in metres, of any point of the part's surface: the sum of the
// ways in which the parameters' deviations can move it, whatever their correlations (a sum deviates
// by no more than its terms together). With s of FitQuality::parameter_sigma and |s| the root of
// the sum of squares over a vector's coordinates:
//   sphere      |s_centre| + s_radius
//   cylinder    |s_q| + R |s_axis| + s_radius            R: from q to the rim, its farthest point
//   cone        s_flank + L (|s_axis| + s_half_angle)    L: from the apex to the farther rim; s_flank:
//               how far the apex moves it, |s_apex| or the sum of its coordinates' shares, of what
//               is along the axis a the sine of the half angle, whichever is less
//   plate       s_d + D |s_normal|                       D: the diagonal around its outline
//   box         |s_sizes|                                one face may have moved by all of it
// Of other shapes, and where the deviations are unknown, the fit's rms_m: their scatter is all that
// is known of its points. Without a fit 0: nothing is invented. Ends that were not seen have none.
//
// Of a plate: nearest to the points that it was fitted to, a plane is known at least as well as it
// is at the origin (s_d), and none of its points is farther from there than D.
double SurfaceSigma_m(const ShapePart& part);

}  // namespace cwm
