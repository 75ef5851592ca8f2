#include "perception/fit/model_selection.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "perception/cloud/quantile.h"
#include "perception/fit/ground_contact.h"
#include "perception/fit/solid.h"

namespace cwm::perception {
namespace {

// chosen: points whose normals give the first guesses of an axis.
constexpr std::size_t kFanPoints = 120;

// chosen: one more parameter must lower the rms to less than this share of the simpler shape's.
constexpr double kMaxRms = 0.95;
// derived: 2 sqrt(180), see IsSignificant.
constexpr double kFlatCurvature = 26.8;
// chosen: a candidate is an alternative for a region if this share of its points lies in it.
constexpr double kOverlap = 0.3;
// derived: a view shows one of the two faces across each axis of a box.
constexpr int kFacesSeen = Vector3::RowsAtCompileTime;
// chosen: starting points for the faces of a region, so that each of three faces has some.
constexpr std::size_t kFaceSeeds = 40;

CurvedEvidence EvidenceOf(double radius_m, double arc_rad) {
  const double half = std::min(0.5 * arc_rad, 0.5 * std::numbers::pi);
  return {.radius_m = radius_m,
          .arc_rad = arc_rad,
          .chord_m = 2 * radius_m * std::sin(half),
          .sagitta_m = radius_m * (1 - std::cos(half))};
}

// Returns the direction in which the normals vary least: the axis of a cylinder (about zero) or of
// a cone (about their mean).
enum class FanCenter { kZero, kMean };
Vector3 AxisOfFan(const std::vector<SamplePoint>& fan, FanCenter center) {
  Vector3 mean = Vector3::Zero();
  Matrix3 products = Matrix3::Zero();
  for (const SamplePoint& s : fan) {
    mean += s.n / static_cast<double>(fan.size());
    products += s.n * s.n.transpose() / static_cast<double>(fan.size());
  }
  if (center == FanCenter::kMean) products -= mean * mean.transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3>(products).eigenvectors().col(0);
}

PlaneModel MeanPlane(const std::vector<SamplePoint>& fan) {
  PlaneModel plane;
  Vector3 normal = Vector3::Zero();
  for (const SamplePoint& s : fan) {
    plane.point += s.p / static_cast<double>(fan.size());
    normal += s.n;
  }
  if (normal.norm() > 1e-6) plane.normal = normal.normalized();
  return plane;
}

std::vector<SamplePoint> FanOf(const std::vector<std::uint32_t>& inliers, const FitContext& c) {
  std::vector<SamplePoint> fan;
  for (std::uint32_t i : Subsampled(inliers, kFanPoints))
    fan.push_back({c.points.p[i], c.points.n[i]});
  return fan;
}

// The best-scored candidates of other kinds that lie mostly on the leader's points.
std::vector<AnyModel> OverlappingCandidates(const Candidate& leader, const CandidateList& list,
                                            const FitContext& c) {
  std::vector<char> on_leader(c.points.size(), 0);
  for (std::uint32_t i : leader.inliers) on_leader[i] = 1;
  const Candidate* best[std::variant_size_v<AnyModel>] = {};
  for (const Candidate& candidate : list.candidates()) {
    const std::size_t kind = candidate.model.index();
    if (kind == leader.model.index()) continue;
    if (best[kind] != nullptr && best[kind]->score >= candidate.score) continue;
    std::size_t shared = 0;
    for (std::uint32_t i : candidate.inliers) shared += on_leader[i] ? 1 : 0;
    if (static_cast<double>(shared) >= kOverlap * static_cast<double>(candidate.inliers.size())) {
      best[kind] = &candidate;
    }
  }
  std::vector<AnyModel> models;
  for (const Candidate* candidate : best) {
    if (candidate != nullptr) models.push_back(candidate->model);
  }
  return models;
}

struct Proposal {
  AnyModel model;
  AxisFreedom axis = AxisFreedom::kFree;
};

// Proposes a cylinder and a cone around the axis. Upright ones have two degrees of freedom less: a
// cup seen from one side looks like a leaning can.
void ProposeAround(const std::vector<SamplePoint>& fan, const Vector3& axis, AxisFreedom freedom,
                   const ModelerOptions& options, std::vector<Proposal>& proposals) {
  if (options.search_cylinders) {
    const auto cylinder = CylinderModel::AroundAxis(fan, axis);
    if (cylinder) proposals.push_back({*cylinder, freedom});
  }
  if (options.search_cones) {
    const auto cone = ConeModel::AroundAxis(fan, axis);
    if (cone) proposals.push_back({*cone, freedom});
  }
}

std::vector<Proposal> Proposals(const Candidate& leader, const CandidateList& list,
                                const FitContext& c) {
  std::vector<Proposal> proposals;
  proposals.push_back({leader.model});
  const std::vector<SamplePoint> fan = FanOf(leader.inliers, c);
  if (c.options.search_planes && !IsPlane(leader.model)) proposals.push_back({MeanPlane(fan)});
  if (c.options.search_spheres) {
    if (const auto sphere = SphereModel::FromSample(fan)) proposals.push_back({*sphere});
  }
  ProposeAround(fan, c.ground.up, AxisFreedom::kHeld, c.options, proposals);
  ProposeAround(fan, AxisOfFan(fan, FanCenter::kZero), AxisFreedom::kFree, c.options, proposals);
  ProposeAround(fan, AxisOfFan(fan, FanCenter::kMean), AxisFreedom::kFree, c.options, proposals);
  for (AnyModel& model : OverlappingCandidates(leader, list, c)) proposals.push_back({model});
  return proposals;
}

// Returns one fit per kind and freedom of the axis, the one with the most inliers, sorted by
// degrees of freedom.
std::vector<ShapeFit> FitAlternatives(const Candidate& leader, const CandidateList& list,
                                      const FitContext& c) {
  std::vector<ShapeFit> alternatives;
  const auto keep = [&](std::optional<ShapeFit> fit) {
    if (!fit || !IsSignificantlyCurved(*fit, c)) return;
    for (ShapeFit& alternative : alternatives) {
      if (alternative.model.index() != fit->model.index() || alternative.axis != fit->axis)
        continue;
      if (fit->inliers.size() > alternative.inliers.size()) alternative = *std::move(fit);
      return;
    }
    alternatives.push_back(*std::move(fit));
  };
  for (const Proposal& proposal : Proposals(leader, list, c)) {
    keep(FitShape(proposal.model, proposal.axis, c, list.available()));
  }
  if (c.options.search_cones) {  // a cone may start from a cylinder
    for (std::size_t k = 0, count = alternatives.size(); k < count; ++k) {
      const auto* cylinder = std::get_if<CylinderModel>(&alternatives[k].model);
      if (cylinder == nullptr) continue;
      keep(FitShape(cylinder->AsCone(), alternatives[k].axis, c, list.available()));
    }
  }
  std::stable_sort(alternatives.begin(), alternatives.end(),
                   [](const ShapeFit& a, const ShapeFit& b) {
                     const int of_a = DegreesOfFreedom(a.model, a.axis);
                     const int of_b = DegreesOfFreedom(b.model, b.axis);
                     return of_a != of_b ? of_a < of_b : a.model.index() < b.model.index();
                   });
  return alternatives;
}

std::vector<std::uint32_t> UnionOfInliers(const std::vector<ShapeFit>& alternatives) {
  std::vector<std::uint32_t> all;
  for (const ShapeFit& fit : alternatives) {
    all.insert(all.end(), fit.inliers.begin(), fit.inliers.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// Returns the plane through one of the listed points that most of them lie on, refined on those.
std::optional<PlaneModel> LargestFace(const std::vector<std::uint32_t>& listed,
                                      const FitContext& c) {
  std::vector<std::uint32_t> best;
  PlaneModel plane;
  for (std::uint32_t seed : Subsampled(listed, kFaceSeeds)) {
    c.work.Poll();
    const PlaneModel trial{.point = c.points.p[seed], .normal = c.points.n[seed]};
    std::vector<std::uint32_t> inliers;
    for (std::uint32_t i : listed) {
      if (IsInlier(trial, c.points, i)) inliers.push_back(i);
    }
    if (inliers.size() > best.size()) best = std::move(inliers), plane = trial;
  }
  const auto refined = Refine(plane, c.points, best, RefineOptions{.noise = c.noise});
  if (!refined) return std::nullopt;
  return refined->model;
}

std::vector<PlaneModel> FacesOf(const std::vector<std::uint32_t>& listed, const FitContext& c) {
  std::vector<PlaneModel> faces;
  std::vector<std::uint32_t> rest = Subsampled(listed, 500);
  while (static_cast<int>(faces.size()) < kFacesSeen && rest.size() >= 10) {
    const std::optional<PlaneModel> face = LargestFace(rest, c);
    if (!face) break;
    faces.push_back(*face);
    std::erase_if(rest, [&](std::uint32_t i) { return IsInlier(*face, c.points, i); });
  }
  return faces;
}

// True unless the fit is a cone whose slope is not significant.
bool SlopeIsSignificant(const ShapeFit& fit) {
  const auto* cone = std::get_if<ConeModel>(&fit.model);
  if (cone == nullptr) return true;
  return std::abs(cone->slope) >
         std::max(kMinSlope, kMinSlope_sigma *
                                 std::sqrt(fit.covariance(ConeModel::kSlope, ConeModel::kSlope)));
}

// The index of the best alternative; `alternatives` are sorted by their degrees of freedom.
std::size_t BestOf(const std::vector<ShapeFit>& alternatives,
                   const std::vector<std::uint32_t>& region, const FitContext& c) {
  std::size_t best = 0;
  Criterion best_value = EvaluateCriterion(alternatives[0].model, alternatives[0].axis, c, region);
  for (std::size_t k = 1; k < alternatives.size(); ++k) {
    const Criterion value =
        EvaluateCriterion(alternatives[k].model, alternatives[k].axis, c, region);
    const bool leans = alternatives[k].axis == AxisFreedom::kFree &&
                       !IsPlane(alternatives[k].model) &&
                       alternatives[best].axis == AxisFreedom::kHeld;
    if (value.value + (leans ? kUprightPrior : 0) < best_value.value &&
        value.rms_sigma < kMaxRms * best_value.rms_sigma) {
      best = k, best_value = value;
    }
  }
  return best;
}

// True unless the fit is a cone whose slope is neither significant nor decisively better than the
// best cylinder.
bool IsWorthItsSlope(const ShapeFit& fit, double value, double straight_value) {
  const auto* cone = std::get_if<ConeModel>(&fit.model);
  if (cone == nullptr || SlopeIsSignificant(fit)) return true;
  return std::abs(cone->slope) > kMinSlope && value + kDecisive < straight_value;
}

double ValueOf(const ShapeFit& fit, const std::vector<std::uint32_t>& region, const FitContext& c) {
  return EvaluateCriterion(fit.model, fit.axis, c, region).value;
}

double BestCylinder(const std::vector<ShapeFit>& alternatives,
                    const std::vector<std::uint32_t>& region, const FitContext& c) {
  double best = std::numeric_limits<double>::infinity();
  for (const ShapeFit& alternative : alternatives) {
    if (!std::holds_alternative<CylinderModel>(alternative.model)) continue;
    best = std::min(best, ValueOf(alternative, region, c));
  }
  return best;
}

// The best of the fits that rest on the ground.
struct Lying {
  std::optional<ShapeFit> fit;
  double value = 0;

  void Offer(std::optional<ShapeFit> other, const std::vector<std::uint32_t>& region,
             double straight_value, const FitContext& c) {
    if (!other || !IsSignificantlyCurved(*other, c)) return;
    const double its_value = ValueOf(*other, region, c);
    if (!IsWorthItsSlope(*other, its_value, straight_value)) return;
    if (!fit || its_value < value) fit = std::move(other), value = its_value;
  }
};

// True if two or three planes explain the region better than the curved shape.
bool FacesExplainBetter(const ShapeFit& curved, const std::vector<std::uint32_t>& region,
                        const FitContext& context) {
  const double alternative = EvaluateCriterion(curved.model, curved.axis, context, region).value;
  // An upright curved shape is likely, so faces must be decisively better. A leaning round edge is
  // more likely the rounded normals of a crease.
  const double margin = curved.axis == AxisFreedom::kHeld ? kDecisive : 0;
  std::vector<PlaneModel> faces = FacesOf(region, context);
  for (; faces.size() >= 2; faces.pop_back()) {
    if (EvaluateCriterion(faces, context, region).value + margin < alternative) return true;
  }
  return false;
}

// Returns the last refinement of a fit; empty if faces explain its inliers better or it breaks its
// limits.
std::optional<ShapeFit> Finished(const ShapeFit& alternative, const CandidateList& candidates,
                                 const FitContext& c) {
  const bool curved = !IsPlane(alternative.model);
  if (curved && c.options.search_planes &&
      FacesExplainBetter(alternative, alternative.inliers, c)) {
    return std::nullopt;
  }
  std::optional<ShapeFit> finished = FinishFit(alternative, c, candidates.available());
  if (!finished || !IsSignificantlyCurved(*finished, c)) return std::nullopt;
  return finished;
}

}  // namespace

CurvedEvidence MeasureEvidence(const SphereModel& sphere, const ShapeFit& fit,
                               const FitContext& context) {
  Vector3 middle = Vector3::Zero();
  for (std::uint32_t i : fit.inliers) middle += sphere.Normal(context.points.p[i]);
  if (!(middle.norm() > 0)) return EvidenceOf(sphere.radius_m, std::numbers::pi);
  middle.normalize();
  std::vector<double> angles;
  for (std::uint32_t i : fit.inliers) {
    const double cosine = middle.dot(sphere.Normal(context.points.p[i]));
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  return EvidenceOf(sphere.radius_m, 2 * Quantile(std::move(angles), 0.95));
}

CurvedEvidence MeasureEvidence(const ConeModel& cone, const ShapeFit& fit,
                               const FitContext& context) {
  Vector3 middle = Vector3::Zero();
  for (std::uint32_t i : fit.inliers) {
    const Vector3 x = context.points.p[i] - cone.point;
    middle += (x - cone.axis.dot(x) * cone.axis).normalized();
  }
  if (!(middle.norm() > 0)) return EvidenceOf(cone.radius_m, std::numbers::pi);
  middle.normalize();
  const Vector3 aside = cone.axis.cross(middle);
  std::vector<double> angles;
  for (std::uint32_t i : fit.inliers) {
    const Vector3 x = context.points.p[i] - cone.point;
    angles.push_back(std::atan2(aside.dot(x), middle.dot(x)));
  }
  return EvidenceOf(cone.radius_m, Quantile(angles, 0.97) - Quantile(angles, 0.03));
}

bool IsSignificant(const CurvedEvidence& e, double sigma_m, double independent_samples,
                   double min_sigma) {
  // Noise gives the curvature of a flat patch a standard deviation of 26.8 sigma / (sqrt(n) L^2): 2
  // sqrt(180) for a parabola fitted to n points spread evenly over the chord L.
  const double flat_curvature =
      min_sigma * kFlatCurvature * sigma_m /
      (std::sqrt(std::max(1.0, independent_samples)) * e.chord_m * e.chord_m);
  return 1 / e.radius_m > flat_curvature && e.sagitta_m > double{kUnevenness_m} + 0.5 * sigma_m &&
         e.arc_rad >= kMinArc_rad;
}

bool IsSignificantlyCurved(const ShapeFit& fit, const FitContext& context, double min_sigma) {
  double sigma_m = 0;
  for (std::uint32_t i : fit.inliers) sigma_m += context.points.sigma_m[i];
  sigma_m /= static_cast<double>(fit.inliers.size());
  const double samples = context.IndependentSamples(fit.inliers.size());
  if (const auto* sphere = std::get_if<SphereModel>(&fit.model)) {
    return IsSignificant(MeasureEvidence(*sphere, fit, context), sigma_m, samples, min_sigma);
  }
  if (const auto* cylinder = std::get_if<CylinderModel>(&fit.model)) {
    return IsSignificant(MeasureEvidence(cylinder->AsCone(), fit, context), sigma_m, samples,
                         min_sigma);
  }
  if (const auto* cone = std::get_if<ConeModel>(&fit.model)) {
    return IsSignificant(MeasureEvidence(*cone, fit, context), sigma_m, samples, min_sigma);
  }
  return true;
}

std::optional<ShapeFit> SelectModel(const Candidate& leader, const CandidateList& candidates,
                                    const FitContext& context) {
  std::vector<ShapeFit> alternatives = FitAlternatives(leader, candidates, context);
  const std::vector<std::uint32_t> all = UnionOfInliers(alternatives);
  const double straight_value = BestCylinder(alternatives, all, context);
  Lying lying;
  while (!alternatives.empty()) {
    context.work.Poll();
    const std::vector<std::uint32_t> region = UnionOfInliers(alternatives);
    const std::size_t best = BestOf(alternatives, region, context);
    if (lying.fit && lying.value <= ValueOf(alternatives[best], all, context)) break;
    if (std::optional<ShapeFit> finished = Finished(alternatives[best], candidates, context)) {
      if (CanRestOnGround(*finished, context)) {
        lying.Offer(RestOnGround(*finished, context, candidates.available()), all, straight_value,
                    context);
      } else if (IsWorthItsSlope(*finished, ValueOf(*finished, all, context), straight_value)) {
        return finished;
      }
    }
    alternatives.erase(alternatives.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return lying.fit;
}

}  // namespace cwm::perception
