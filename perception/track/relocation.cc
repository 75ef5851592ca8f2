#include "perception/track/relocation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/track/alignment.h"

namespace cwm::perception {
namespace {

// chosen: guesses about the vertical, 30 degrees apart: one is near enough for the alignment.
constexpr int kTurns = 12;
constexpr int kRefined = 3;  // chosen: the best guesses to align; time grows with it
// chosen: the mean distance of the points from the model at a guess that is aligned, half of the
// alignment's reach: more than 15 degrees of turn make on things of arm's length.
constexpr double kMaxStart_m = kAlignmentReach_m / 2;
// chosen: a later guess must score better by this much, so that noise does not turn a can.
constexpr double kTurnMargin = 0.03;
// measured: five times the 95th percentile of the error of a fitted radius under Kinect noise; a
// larger difference means another object.
constexpr double kMaxRadiusDifference_m = 0.008;

std::vector<Eigen::Vector3f> Subsample(const std::vector<Eigen::Vector3f>& points) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSurfaceSamples);
  std::vector<Eigen::Vector3f> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

// The radius of the model's main shape, in metres, if it is round.
std::optional<double> MainRadius_m(const HybridModel& model) {
  const ShapePart* main = nullptr;
  int max_inliers = -1;
  for (const ShapePart& part : model.shapes) {
    const int inliers = part.fit ? part.fit->inlier_count : 0;
    if (inliers <= max_inliers) continue;
    max_inliers = inliers;
    main = &part;
  }
  if (main == nullptr) return std::nullopt;
  if (const auto* sphere = std::get_if<Sphere>(&main->shape)) return sphere->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&main->shape)) return cylinder->radius_m;
  return std::nullopt;
}

bool SizesAgree(const HybridModel& known, const HybridModel& detected) {
  const auto known_m = MainRadius_m(known);
  const auto detected_m = MainRadius_m(detected);
  if (known_m && detected_m && std::abs(*known_m - *detected_m) > kMaxRadiusDifference_m)
    return false;
  const double size_m = TightBounds(known, Pose::Identity()).diagonal().norm();
  const double other_m = TightBounds(detected, Pose::Identity()).diagonal().norm();
  // The detection may show a part of the object only.
  return std::min(size_m, other_m) > kMajority * std::max(size_m, other_m);
}

// The known pose, rotated about the vertical and moved to the middle of the detection's bounds;
// then the detection's own pose, as both models' frames follow the same rules.
std::vector<Pose> Guesses(const KnownEvidence& known, const DetectedEvidence& detected) {
  const Aabb target = TightBounds(*detected.model, detected.X_LO);
  std::vector<Pose> guesses;
  for (int i = 0; i < kTurns; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kTurns;
    Pose X_LO = known.X_LO;
    X_LO.linear() = Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()) * known.X_LO.linear();
    const Aabb bounds = TightBounds(*known.model, X_LO);
    Vector3 shift = target.center() - bounds.center();
    shift.z() = target.min().z() - bounds.min().z();
    X_LO.translation() += shift;
    guesses.push_back(X_LO);
  }
  guesses.push_back(detected.X_LO);
  return guesses;
}

}  // namespace

std::optional<Relocation> Relocate(const ObjectEvidence& evidence, int k, int d,
                                   const ScanEvidence& scan) {
  const KnownEvidence& known = evidence.known[k];
  const DetectedEvidence& detected = evidence.detected[d];
  if (detected.points.points_L.empty() || !SizesAgree(*known.model, *detected.model)) {
    return std::nullopt;
  }
  const ModelSurface& surface = known.surface;
  const std::vector<Eigen::Vector3f> points_L = Subsample(detected.points.points_L);
  const double gate_m = scan.Gate_m(detected.X_LO.translation());
  std::vector<std::pair<double, Pose>> ranked;
  for (const Pose& guess : Guesses(known, detected)) {
    ranked.emplace_back(MeanDistance_m(points_L, surface, guess), guess);
  }
  // The known orientation is always tried, as the first guess.
  std::stable_sort(ranked.begin() + 1, ranked.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::optional<Relocation> best;
  for (int i = 0; i <= kRefined; ++i) {
    if (ranked[i].first > kMaxStart_m) continue;
    const Pose X_LO = Align(points_L, surface, ranked[i].second, gate_m);
    // Most poses are wrong, which a part of the points shows.
    const std::vector<double> within_m(points_L.size(), gate_m);
    const double share = ShareOf(Explained(points_L, within_m, surface, X_LO));
    if (share < kMajority * std::min(kNearlyAll, detected.own_share)) continue;
    const PlacedFit fit = evidence.FitAt(k, X_LO, d);
    // The detection must cover the larger part of the model's seen surface at the new place.
    if (!evidence.IsAsGoodAsDetected(fit, d) || fit.covered_share < kMajority) continue;
    if (!best || fit.Score() > best->fit.Score() + kTurnMargin) best = {X_LO, fit};
  }
  return best;
}

}  // namespace cwm::perception
