#include "perception/track/object_evidence.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/track/alignment.h"
#include "perception/track/ray_classification.h"

namespace cwm::perception {
namespace {

// derived: a surface in view has a thinned point within twice the spacing, besides the noise.
constexpr double kPointDistance_m = kThinningSpacing_m * 2;

// chosen: the share of a part's visible surface that rays pass through once it is gone. A part that
// the model completed a little too far is passed at its border.
constexpr double kLostShare = 0.8;

const HybridModel& ModelOrEmpty(const std::shared_ptr<const HybridModel>& model) {
  static const HybridModel kEmpty;
  return model ? *model : kEmpty;
}

void Merge(const std::vector<char>& mask, std::vector<char>& into) {
  for (std::size_t i = 0; i < mask.size(); ++i) into[i] |= mask[i];
}

Aabb Inflated(const Aabb& bounds, double by_m) {
  return {bounds.min() - Vector3::Constant(by_m), bounds.max() + Vector3::Constant(by_m)};
}

}  // namespace

ObjectEvidence::ObjectEvidence(const std::vector<KnownObject>& known_objects,
                               const SceneInterpretation& scene, const ScanEvidence& scan)
    : scan_(scan), reach_m_(std::max(kExplainedWithin_m, kAlignmentReach_m)) {
  for (const DetectedSupport& support : scene.supports) {
    const Aabb bounds = TightBounds(ModelOrEmpty(support.model), Pose::Identity());
    supports_.push_back(
        {.X_OL = scan_.InLevelFrame(support.X_WO).inverse(),
         .area = {Vector2(bounds.min().head<2>()), Vector2(bounds.max().head<2>())}});
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    AddDetected(scene.objects[i], static_cast<int>(i));
  }
  for (std::size_t i = 0; i < known_objects.size(); ++i) {
    const KnownObject& object = known_objects[i];
    if (object.owned_by_user || object.kind == KnownObject::Kind::kSupport) continue;
    AddKnown(object, static_cast<int>(i));
  }
  MarkUsers(known_objects);
  MarkPresent(known_objects);
}

void ObjectEvidence::AddDetected(const DetectedObject& object, int index) {
  const HybridModel& model = ModelOrEmpty(object.model);
  const Pose X_LO = scan_.InLevelFrame(object.X_WO);
  const std::vector<SurfaceSample> samples =
      ModelSurface(model, kExplainedWithin_m).Samples(kSurfaceSamples);
  std::vector<Eigen::Vector3f> points_L;
  for (const Eigen::Vector3f& p : object.points_L) {
    if (p.allFinite()) points_L.push_back(p);
  }
  if (points_L.empty()) {  // without points, a detection is represented by its surface
    for (const SurfaceSample& sample : samples) {
      if (scan_.FacesSensor(sample, X_LO)) {
        points_L.push_back((X_LO * sample.p_O).cast<float>());
      }
    }
  }
  DetectedPoints points = scan_.Index(std::move(points_L));
  for (const double gate_m : points.gates_m) reach_m_ = std::max(reach_m_, gate_m);
  for (const double tolerance_m : points.tolerances_m) reach_m_ = std::max(reach_m_, tolerance_m);
  const ModelSurface surface(model, reach_m_);
  const auto own = Explained(points.points_L, points.gates_m, surface, X_LO);
  detected.push_back({.index = index,
                      .kind = object.kind,
                      .X_LO = X_LO,
                      .model = &model,
                      .points = std::move(points),
                      .own_share = ShareOf(own),
                      .own_through_share = SightsOf(samples, X_LO).ThroughShare(),
                      .lost_part = LosesPart(samples, X_LO)});
}

void ObjectEvidence::AddKnown(const KnownObject& object, int index) {
  const HybridModel& model = ModelOrEmpty(object.model);
  const Pose X_LO = scan_.InLevelFrame(object.X_WO);
  const int k = static_cast<int>(known.size());
  known.push_back({.index = index,
                   .kind = object.kind,
                   .X_LO = X_LO,
                   .model = &model,
                   .surface = ModelSurface(model, reach_m_),
                   .samples = {},
                   .sights = {}});
  KnownEvidence& added = known.back();
  added.samples = added.surface.Samples(kSurfaceSamples);
  added.sights = SightsOf(added.samples, X_LO);
  added.lost_part = LosesPart(added.samples, X_LO);
  const Aabb bounds_L = Inflated(TightBounds(model, X_LO), reach_m_);
  for (int d = 0; d < static_cast<int>(detected.size()); ++d) {
    const DetectedPoints& points = detected[d].points;
    if (!bounds_L.intersects(points.bounds_L)) continue;
    auto explained = Explained(points.points_L, points.gates_m, added.surface, X_LO);
    const PlacedFit fit = FitOf(k, X_LO, d, ShareOf(explained), added.sights);
    in_place_[{k, d}] = {.fit = fit, .explained = std::move(explained)};
  }
}

// True if the point lies on a support of the scan. Near an object's foot the support is so close
// behind samples that rays seem to hit them: such samples give no information about the object.
bool ObjectEvidence::OnSupport(const Vector3& p_L) const {
  const double tolerance_m = scan_.Tolerance_m(p_L);
  return std::any_of(supports_.begin(), supports_.end(), [&](const SupportFace& face) {
    const Vector3 p = face.X_OL * p_L;
    return std::abs(p.z()) <= tolerance_m && face.area.contains(Vector2(p.head<2>()));
  });
}

SightCounts ObjectEvidence::SightsOf(const std::vector<SurfaceSample>& samples,
                                     const Pose& X_LO) const {
  SightCounts above;
  SightCounts all;
  for (const SurfaceSample& sample : samples) {
    if (!scan_.FacesSensor(sample, X_LO)) continue;
    const Vector3 p_L = X_LO * sample.p_O;
    const RayVerdict verdict = scan_.VerdictAt(p_L);
    all.Add(verdict);
    if (!OnSupport(p_L)) above.Add(verdict);
  }
  return above.informed() > 0 ? above : all;  // a very flat object lies on its support entirely
}

bool ObjectEvidence::LosesPart(const std::vector<SurfaceSample>& samples, const Pose& X_LO) const {
  std::map<int, std::vector<SurfaceSample>> by_part;
  for (const SurfaceSample& sample : samples) by_part[sample.part].push_back(sample);
  if (by_part.size() < 2) return false;
  return std::ranges::any_of(by_part, [&](const auto& part) {
    const SightCounts sights = SightsOf(part.second, X_LO);
    return sights.visible() >= kMinInformed && sights.ThroughShare() >= kLostShare;
  });
}

PlacedFit ObjectEvidence::FitAt(int k, const Pose& X_LO, int d) const {
  const DetectedPoints& points = detected[d].points;
  const auto explained = Explained(points.points_L, points.gates_m, known[k].surface, X_LO);
  return FitOf(k, X_LO, d, ShareOf(explained), SightsOf(known[k].samples, X_LO));
}

PlacedFit ObjectEvidence::FitOf(int k, const Pose& X_LO, int d, double explained_share,
                                const SightCounts& sights) const {
  std::vector<char> covered;
  for (const SurfaceSample& sample : known[k].samples) {
    const Vector3 p_L = X_LO * sample.p_O;
    if (!scan_.FacesSensor(sample, X_LO) || scan_.VerdictAt(p_L) != RayVerdict::kHit) continue;
    const double within_m = std::max(kPointDistance_m, scan_.Gate_m(p_L));
    covered.push_back(detected[d].points.AnyWithin(p_L, within_m));
  }
  return {.explained_share = explained_share,
          .covered_share = ShareOf(covered),
          .through_share = sights.ThroughShare()};
}

const PlacedFit* ObjectEvidence::FitInPlace(int k, int d) const {
  const auto found = in_place_.find({k, d});
  return found == in_place_.end() ? nullptr : &found->second.fit;
}

bool ObjectEvidence::IsAsGoodAsDetected(const PlacedFit& fit, int d) const {
  const DetectedEvidence& detection = detected[d];
  // The detection's own model is fitted to these points; a known model may explain a tenth less.
  // But a detection that nothing explains well cannot match any object.
  const double own_advantage = 1 - kNearlyAll;
  const double as_own = std::max(detection.own_share - own_advantage,
                                 std::min(detection.own_share, kSubstantialShare));
  // Completed parts may extend a little into free space that was seen.
  const double as_through =
      std::max(kSubstantialShare, detection.own_through_share + own_advantage);
  return fit.explained_share > 0 && fit.explained_share >= std::min(kNearlyAll, as_own) &&
         fit.through_share <= as_through;
}

void ObjectEvidence::MarkUsers(const std::vector<KnownObject>& objects) {
  for (const DetectedEvidence& detection : detected) {
    by_users_.emplace_back(detection.points.points_L.size(), 0);
  }
  for (const KnownObject& object : objects) {
    if (!object.owned_by_user) continue;
    const HybridModel& model = ModelOrEmpty(object.model);
    const ModelSurface surface(model, reach_m_);
    const Pose X_LO = scan_.InLevelFrame(object.X_WO);
    const Aabb bounds_L = Inflated(TightBounds(model, X_LO), reach_m_);
    for (std::size_t d = 0; d < detected.size(); ++d) {
      const DetectedPoints& points = detected[d].points;
      if (!bounds_L.intersects(points.bounds_L)) continue;
      Merge(Explained(points.points_L, points.tolerances_m, surface, X_LO), by_users_[d]);
    }
  }
}

void ObjectEvidence::MarkPresent(const std::vector<KnownObject>& objects) {
  by_present_ = by_users_;
  for (const auto& [pair, in_place] : in_place_) {
    const KnownEvidence& object = known[pair.first];
    if (objects[object.index].is_gone) continue;
    if (ClassifyByRays(object.sights) != Association::Outcome::kKeep) continue;
    if (HasLostPart(pair.first, pair.second)) continue;  // the detection is what is left of it
    Merge(in_place.explained, by_present_[pair.second]);
  }
  // The rest of a known support explains residual geometry, but not a flat object on the support.
  for (const KnownObject& object : objects) {
    if (object.owned_by_user || object.kind != KnownObject::Kind::kSupport) continue;
    const HybridModel& model = ModelOrEmpty(object.model);
    const ModelSurface surface(model, reach_m_);
    const Pose X_LO = scan_.InLevelFrame(object.X_WO);
    const Aabb bounds_L = Inflated(TightBounds(model, X_LO), reach_m_);
    for (std::size_t d = 0; d < detected.size(); ++d) {
      const DetectedPoints& points = detected[d].points;
      const bool residual = detected[d].kind == DetectedKind::kResidual;
      if (!residual || !bounds_L.intersects(points.bounds_L)) continue;
      Merge(Explained(points.points_L, points.gates_m, surface, X_LO), by_present_[d]);
    }
  }
}

double ObjectEvidence::UserShare(int d) const { return ShareOf(by_users_[d]); }

double ObjectEvidence::PresentShare(int d) const { return ShareOf(by_present_[d]); }

double ObjectEvidence::LargestShift_m(int k, const Pose& X_LO) const {
  double largest_m = 0;
  for (const SurfaceSample& sample : known[k].samples) {
    const Vector3 shift = X_LO * sample.p_O - known[k].X_LO * sample.p_O;
    largest_m = std::max(largest_m, shift.norm());
  }
  return largest_m;
}

}  // namespace cwm::perception
