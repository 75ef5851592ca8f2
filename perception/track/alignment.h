// Where a known object went: its pose that brings its surface onto measured points.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "perception/track/model_surface.h"

namespace cwm::perception {

// chosen: points farther away than this do not pull at the start; the model is built with this
// reach. Guesses are rarely farther off.
inline constexpr double kAlignmentReach_m = 0.03;

// Mean distance of the points to the surface placed at X_LO, distances beyond the reach counted as
// the reach.
double MeanDistance_m(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                      const Pose& X_LO);

// Gauss-Newton on the signed distances of the points (point to plane), robust, gates shrinking from
// the reach to `gate_m`. Damped: directions that the points do not determine (the turn of a can
// about its axis) stay as they are in `X_LO_guess`.
Pose Align(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
           const Pose& X_LO_guess, double gate_m);

}  // namespace cwm::perception
