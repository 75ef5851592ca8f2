// Which kind of shape explains a region best: rivals are fitted to it and compared on the union of
// their inliers.
#pragma once

#include <optional>

#include "perception/cloud/tolerances.h"
#include "perception/fit/shape_fit.h"
#include "perception/search/candidate_list.h"

namespace cwm::perception {

// chosen: 20 degrees; wider cups are bowls.
inline constexpr double kMaxCupSlope = 0.36;

// How much of a curved surface its inliers show.
struct CurvedEvidence {
  double radius_m = 0;
  double arc_rad = 0;    // about the axis, or across the cap of a sphere
  double chord_m = 0;    // of that arc
  double sagitta_m = 0;  // its height over the chord
};
CurvedEvidence MeasureEvidence(const SphereModel& sphere, const ShapeFit& fit,
                               const FitContext& context);
CurvedEvidence MeasureEvidence(const ConeModel& cone, const ShapeFit& fit,
                               const FitContext& context);

// Shorter arcs of real objects are rare, bent edges and warped faces are not.
// chosen: with it no box of the labelled Kinect scans has a curved face.
inline constexpr double kMinArc_rad = 35 * kDegree;

// derived: standard deviations of a flat patch's curvature that a patch found by itself is beyond.
inline constexpr double kMinCurvature_sigma = kNoiseReach_sigma;

// Whether the curvature is beyond what noise and the slow warp of sensors make of a flat patch:
// 1/R > least * 26.8 sigma / (sqrt(n_eff) L^2) and a sagitta above 1 mm + 0.5 sigma for the chord
// L, and an arc of at least kMinArc_rad.
bool IsSignificant(const CurvedEvidence& evidence, double sigma_m, double independent_samples,
                   double least_sigma = kMinCurvature_sigma);

// derived: slopes of cones, else they are cylinders: 2 degrees, which the slow warp of the sensor
// (1.3 mm) makes of a wall of 40 mm. And beyond so many standard deviations.
inline constexpr double kMinSlope = 0.035, kMinSlope_sigma = kDistanceGate_sigma;

// The above, of the inliers of a fit; planes are as curved as they should be.
bool IsSignificantlyCurved(const ShapeFit& fit, const FitContext& context,
                           double least_sigma = kMinCurvature_sigma);

// The best shape for the points of `leader`, finished, or nothing when none holds its limits. A
// shape of higher order must lower the criterion and the rms by 5 %; a curved one must also beat
// up to three planes together (the faces of a box).
std::optional<ShapeFit> SelectModel(const Candidate& leader, const CandidateList& candidates,
                                    const FitContext& context);

}  // namespace cwm::perception
