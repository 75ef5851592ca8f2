#include "perception/live/body_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/track/alignment.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {
namespace {

// chosen: samples of one surface; 20 bodies of so many are judged in a millisecond.
constexpr int kScoreSamples = 300;
// chosen: a pose is confirmed by so many samples that the frame shows.
constexpr int kMinHits = 12;
// chosen: the share of its points that the body must explain. Fingers beside it take the rest.
constexpr double kMinExplained = 0.5;
// measured: rays that pass a surface at its ragged outline are at most a fifth of those that see
// it. The score is this share of that at rest at least.
constexpr double kMinScore = 0.6;
// chosen: scores that differ by less are equal: some samples at the outline flicker.
constexpr double kScoreNoise = 0.05;
// chosen: a region of a body may also have parts of what holds it.
constexpr double kRegionOfBody = 1.3;
// chosen: less of it, by length, could be a part of anything.
constexpr double kMinRegionOfBody = 0.5;
// chosen: points of one body are a few pixels apart, so that this many say as much as one.
constexpr double kPointsPerSample = 4;
// derived: what an acceleration of 2 m/s^2 adds within a thirtieth of a second, and the error of
// the speed.
constexpr double kPredicted_m = 0.002;
// chosen: a pose replaces another of equal score only if the points lie nearer by this share.
constexpr double kCloser = 0.8;

double LeverOf(const std::vector<SurfaceSample>& samples) {
  double squares = 0;
  for (const SurfaceSample& sample : samples) squares += sample.p_O.squaredNorm();
  return std::max(0.01, std::sqrt(squares / std::max<std::size_t>(1, samples.size())));
}

double ExplainedShare(const std::vector<Eigen::Vector3f>& points_L, const ModelSurface& surface,
                      const Pose& X_LB, double gate_m) {
  return ShareOf(Explained(points_L, std::vector<double>(points_L.size(), gate_m), surface, X_LB));
}

Pose InLevelFrame(const FrameEvidence& frame, Pose X_WB) {
  X_WB.translation() -= frame.X_WC.translation();
  return X_WB;
}

}  // namespace

BodySurface::BodySurface(std::shared_ptr<const HybridModel> model)
    : model_(std::move(model)),
      surface_(*model_, kAlignmentReach_m),
      samples_(surface_.Samples(kScoreSamples)),
      lever_m_(LeverOf(samples_)),
      bounds_O_(TightBounds(*model_, Pose::Identity())) {}

double PoseScore::value() const {
  return visible() == 0 ? 0 : static_cast<double>(hit - through) / visible();
}

double FitGate_m(const FrameEvidence& frame, const Pose& X_WB) {
  const double range_m = (X_WB.translation() - frame.X_WC.translation()).norm();
  return kGate_sigma * std::hypot(frame.noise.AxialSigma_m(range_m), frame.noise.WarpSigma_m(),
                                  frame.pose_sigma.At_m(range_m));
}

std::optional<SeenSample> SeenAt(const FrameEvidence& frame, const Pose& X_CB,
                                 const SurfaceSample& sample) {
  const Vector3 p_C = X_CB * sample.p_O;
  const double facing = (X_CB.linear() * sample.normal_O).dot(p_C);
  // Grazing samples have returns of what is beside them.
  const bool is_seen =
      std::abs(facing) > kMinSignificantShare * p_C.norm() && (facing < 0 || sample.two_sided);
  if (p_C.z() <= 0 || !is_seen) return std::nullopt;
  const Pinhole& pinhole = frame.camera.pinhole;
  const DepthImage& image = *frame.image;
  SeenSample seen{.p_C = p_C, .measured_m = std::nullopt};
  const auto u =
      static_cast<int>(std::lround(pinhole.focal_u_px * p_C.x() / p_C.z() + pinhole.center_u_px));
  const auto v =
      static_cast<int>(std::lround(pinhole.focal_v_px * p_C.y() / p_C.z() + pinhole.center_v_px));
  if (u < 0 || v < 0 || u >= image.width || v >= image.height) return seen;
  if (image.at(u, v) != 0) seen.measured_m = image.at(u, v);
  return seen;
}

PoseScore ScoreOf(const FrameEvidence& frame, const BodySurface& body, const Pose& X_WB) {
  PoseScore score;
  const Pose X_CB = frame.X_WC.inverse() * X_WB;
  const double gate_m = FitGate_m(frame, X_WB);
  for (const SurfaceSample& sample : body.samples()) {
    const auto seen = SeenAt(frame, X_CB, sample);
    if (!seen || !seen->measured_m) continue;
    if (*seen->measured_m < seen->p_C.z() - gate_m) {
      ++score.hidden;
    } else if (*seen->measured_m > seen->p_C.z() + gate_m) {
      ++score.through;
    } else {
      ++score.hit;
    }
  }
  return score;
}

double LargestShift_m(const BodySurface& body, const Pose& X_WB, const Pose& X_WB_other) {
  double largest_m = 0;
  for (const SurfaceSample& sample : body.samples()) {
    largest_m = std::max(largest_m, (X_WB * sample.p_O - X_WB_other * sample.p_O).norm());
  }
  return largest_m;
}

bool PlacedSurface::Explains(const Vector3& p_L, double within_m) const {
  const Vector3 p_O = X_LB.inverse() * p_L;
  if (surface->bounds_O().squaredExteriorDistance(p_O) > within_m * within_m) return false;
  const auto nearest = surface->surface().Nearest(p_O, within_m);
  return nearest && nearest->signed_distance_m <= within_m;
}

std::vector<Eigen::Vector3f> OwnPoints(const BodyEvidence& evidence,
                                       std::span<const PlacedSurface> supports, double within_m) {
  std::vector<Eigen::Vector3f> own = evidence.points_L;
  std::erase_if(own, [&](const Eigen::Vector3f& p) {
    return std::ranges::any_of(supports, [&](const PlacedSurface& support) {
      return support.Explains(p.cast<double>(), within_m);
    });
  });
  return own;
}

std::optional<Pose> FitPose(const FrameEvidence& frame,
                            const std::vector<Eigen::Vector3f>& points_L, const BodySurface& body,
                            double rest_score, const Pose& X_WB_old, const Pose& X_WB_guess,
                            FitFor purpose) {
  if (points_L.size() < kTwoSamples) return std::nullopt;
  const double gate_m = FitGate_m(frame, X_WB_guess);
  const Pose X_LB_guess = InLevelFrame(frame, X_WB_guess);
  // The prediction of a motion is right within the noise; a motion that begins is anywhere near.
  const double first_gate_m = purpose == FitFor::kGoOn ? 2 * gate_m : kAlignmentReach_m;
  const Pose X_LB_shifted =
      AlignTranslation(points_L, body.surface(), X_LB_guess, gate_m, first_gate_m);
  Pose X_LB = Align(points_L, body.surface(), X_LB_shifted, gate_m, first_gate_m);
  if (purpose == FitFor::kGoOn) {
    const double sigma_m = frame.noise.AxialSigma_m(X_LB.translation().norm());
    X_LB = WithPrediction(points_L, body.surface(), X_LB, X_LB_guess, gate_m,
                          std::sqrt(kPointsPerSample) * sigma_m, kPredicted_m);
  }
  const double share = ExplainedShare(points_L, body.surface(), X_LB, gate_m);
  if (share < kMinExplained) return std::nullopt;
  Pose X_WB = X_LB;
  X_WB.translation() += frame.X_WC.translation();
  const PoseScore score = ScoreOf(frame, body, X_WB);
  const double least_score = kMinScore * std::clamp(rest_score, 0.0, 1.0);
  if (score.hit < kMinHits || score.value() < least_score) return std::nullopt;
  const PoseScore old = ScoreOf(frame, body, X_WB_old);
  if (purpose == FitFor::kGoOn) {
    if (score.value() < old.value() - kScoreNoise) return std::nullopt;
    return X_WB;
  }
  if (score.value() < old.value()) return std::nullopt;
  if (score.value() > old.value() + kScoreNoise) return X_WB;
  const Pose X_LB_old = InLevelFrame(frame, X_WB_old);
  const double old_share = ExplainedShare(points_L, body.surface(), X_LB_old, gate_m);
  const double distance_m = MeanDistance_m(points_L, body.surface(), X_LB);
  const double old_m = MeanDistance_m(points_L, body.surface(), X_LB_old);
  if (share < old_share || distance_m > kCloser * old_m) return std::nullopt;
  return X_WB;
}

namespace {

// The middle of the samples that face the sensor, in the frame L.
Vector3 VisibleMiddle_L(const BodySurface& body, const Pose& X_LB) {
  Vector3 sum_L = Vector3::Zero();
  double count = 0;
  for (const SurfaceSample& sample : body.samples()) {
    const Vector3 p_L = X_LB * sample.p_O;
    if (!sample.two_sided && (X_LB.linear() * sample.normal_O).dot(p_L) >= 0) continue;
    sum_L += p_L;
    ++count;
  }
  return count == 0 ? Vector3(X_LB.translation()) : Vector3(sum_L / count);
}

// An even choice of at most kMaxBodyPoints of the points.
std::vector<Eigen::Vector3f> SomeOf(const std::vector<Eigen::Vector3f>& points) {
  const std::size_t step = 1 + points.size() / kMaxBodyPoints;
  std::vector<Eigen::Vector3f> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

}  // namespace

std::optional<Pose> FindInRegions(const FrameEvidence& frame, const BodySurface& body,
                                  double rest_score, const Pose& X_WB_old) {
  const Pose X_LB_old = InLevelFrame(frame, X_WB_old);
  const Vector3 middle_L = VisibleMiddle_L(body, X_LB_old);
  const double diagonal_m = body.bounds_O().diagonal().norm();
  for (const HotRegion& region : frame.regions) {
    if (region.points_L.size() < kThreeSamples) continue;
    Eigen::AlignedBox3f bounds_L;
    Vector3 sum_L = Vector3::Zero();
    for (const Eigen::Vector3f& p : region.points_L) {
      bounds_L.extend(p);
      sum_L += p.cast<double>();
    }
    const double size = bounds_L.diagonal().norm() / diagonal_m;
    if (size < kMinRegionOfBody || size > kRegionOfBody) continue;
    const Vector3 shift_W = sum_L / static_cast<double>(region.points_L.size()) - middle_L;
    // Without a shift it was looked for already.
    if (shift_W.norm() < kAlignmentReach_m / 2) continue;
    Pose X_WB_guess = X_WB_old;
    X_WB_guess.translation() += shift_W;
    const auto found = FitPose(frame, SomeOf(region.points_L), body, rest_score, X_WB_old,
                               X_WB_guess, FitFor::kStart);
    if (found) return found;
  }
  return std::nullopt;
}

}  // namespace cwm::perception
