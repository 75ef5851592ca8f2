// Finds the pose of a known object that brings its surface onto measured points.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "perception/track/model_surface.h"

namespace cwm::perception {

// chosen: points farther away than this have no effect at the start, and the model is built with
// this reach. Guesses are rarely farther away.
inline constexpr double kAlignmentReach_m = 0.03;

// Mean distance of the points from the surface placed at X_LO, in metres; larger distances count as
// the reach.
double MeanDistance_m(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                      const Pose& X_LO);

// Gauss-Newton on the signed distances of the points (point to plane) with robust weights; the gate
// shrinks from `first_gate_m`, within which the guess is right, to `gate_m`. It is damped:
// directions that the points do not determine (the rotation of a can about its axis) stay as in
// `X_LO_guess`.
Pose Align(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
           const Pose& X_LO_guess, double gate_m, double first_gate_m = kAlignmentReach_m);

// The same for translations alone: the orientation stays. Before Align it keeps a motion from being
// taken for a turn that the points do not determine (a ball that rolls or slides).
Pose AlignTranslation(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                      const Pose& X_LO_guess, double gate_m,
                      double first_gate_m = kAlignmentReach_m);

// The pose between an aligned and a predicted one that is most likely, given their errors: each
// point says `1 / point_sigma_m^2` about the aligned pose, and the prediction is good to
// `prior_sigma_m` in each direction, and to a quarter of it in turns, as lengths at the points.
// Directions that the points
// hardly determine follow the prediction.
Pose WithPrediction(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                    const Pose& X_LO_aligned, const Pose& X_LO_predicted, double gate_m,
                    double point_sigma_m, double prior_sigma_m);

}  // namespace cwm::perception
