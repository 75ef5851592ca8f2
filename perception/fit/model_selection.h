// Chooses the kind of shape that explains a region best: the alternatives are fitted to it and
// compared on the union of their inliers.
#pragma once

#include <optional>

#include "perception/cloud/tolerances.h"
#include "perception/fit/shape_fit.h"
#include "perception/search/candidate_list.h"

namespace cwm::perception {

// chosen: the largest slope of a cup, 20 degrees; wider ones are bowls.
inline constexpr double kMaxCupSlope = 0.36;

// The part of a curved surface that its inliers show.
struct CurvedEvidence {
  double radius_m = 0;
  double arc_rad = 0;    // the angle about the axis, or across the cap of a sphere
  double chord_m = 0;    // chord of that arc
  double sagitta_m = 0;  // height of the arc over its chord
};
CurvedEvidence MeasureEvidence(const SphereModel& sphere, const ShapeFit& fit,
                               const FitContext& context);
CurvedEvidence MeasureEvidence(const ConeModel& cone, const ShapeFit& fit,
                               const FitContext& context);

// The least arc of a curved surface. Real objects rarely show shorter ones, but bent edges and
// warped faces do.
// chosen: with it no box of the labelled Kinect scans has a curved face.
inline constexpr double kMinArc_rad = 35 * kDegree;

// derived: the least curvature of an isolated patch, in standard deviations of the curvature that
// noise gives a flat patch.
inline constexpr double kMinCurvature_sigma = kNoiseReach_sigma;

// True if the curvature is beyond what noise and the slow warp of sensors give a flat patch: 1/R >
// min_sigma * 26.8 sigma / (sqrt(n_eff) L^2) for the chord L, the sagitta is above 1 mm + 0.5
// sigma, and the arc is at least kMinArc_rad.
bool IsSignificant(const CurvedEvidence& evidence, double sigma_m, double independent_samples,
                   double min_sigma = kMinCurvature_sigma);

// derived: the least slope of a cone; flatter ones are cylinders. The slow warp of the sensor (1.3
// mm) gives a wall of 40 mm a slope of 2 degrees. The slope must also be this many standard
// deviations from 0.
inline constexpr double kMinSlope = 0.035, kMinSlope_sigma = kDistanceGate_sigma;

// The same for the inliers of a fit; always true for planes.
bool IsSignificantlyCurved(const ShapeFit& fit, const FitContext& context,
                           double min_sigma = kMinCurvature_sigma);

// Returns the best shape for the points of `leader`, finished; empty if none is within its limits.
// A shape of higher order must lower the criterion, and the rms by 5 %. A curved one must also beat
// up to three planes together, the faces of a box.
std::optional<ShapeFit> SelectModel(const Candidate& leader, const CandidateList& candidates,
                                    const FitContext& context);

}  // namespace cwm::perception
