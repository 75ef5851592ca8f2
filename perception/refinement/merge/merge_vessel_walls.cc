#include "perception/refinement/merge/merge_vessel_walls.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/hypotheses/point_sample.h"
#include "perception/modeler/object_modeler.h"
#include "perception/refinement/evidence.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

bool IsSmall(const ObjectHypothesis& hypothesis) {
  const Eigen::AlignedBox3f& bounds = hypothesis.model->bounds_L;
  return hypothesis.plates.empty() && !bounds.isEmpty() &&
         bounds.diagonal().norm() <= kMaxObjectSize_m;
}

bool IsFlat(const HypothesisModel& model) {
  const auto flat = std::ranges::count_if(model.part_of_point(), [&](std::int32_t part) {
    if (part < 0 || static_cast<std::size_t>(part) >= model.shapes().size()) return false;
    const ShapeKind kind = KindOf(model.shapes()[static_cast<std::size_t>(part)].shape);
    return kind == ShapeKind::kBox || kind == ShapeKind::kPlate;
  });
  return static_cast<double>(flat) >=
         kNearlyAll * static_cast<double>(model.part_of_point().size());
}

// True for a small object that may be a part of a lying vessel: one that is not flat, not a closed
// solid, has no standing vessel (which might also be modelled as a lying one), and whose shapes no
// pass supplied.
bool MayBeOfLyingVessel(const ObjectHypothesis& hypothesis) {
  const HypothesisModel& model = *hypothesis.model;
  if (!hypothesis.IsObject() || model.is_given || !IsSmall(hypothesis) || IsFlat(model)) {
    return false;
  }
  const auto stands = [&](const ShapePart& part) {
    return part.vessel && part.X_OS.linear()(2, 2) >= kAligned_cos;
  };
  if (std::ranges::any_of(model.shapes(), stands)) return false;
  return !IsSingleSolid(model.object) || model.shapes().front().vessel;
}

bool Touch(const HypothesisModel& a, const HypothesisModel& b) {
  if (a.bounds_L.exteriorDistance(b.bounds_L) > kMaxTouchingGap_m) return false;
  const auto near = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& q) {
    return (p - q).squaredNorm() <= kMaxTouchingGap_m * kMaxTouchingGap_m;
  };
  return std::ranges::any_of(a.thinned_L, [&](const Eigen::Vector3f& p) {
    return b.bounds_L.exteriorDistance(p) <= kMaxTouchingGap_m &&
           std::ranges::any_of(b.thinned_L, [&](const Eigen::Vector3f& q) { return near(p, q); });
  });
}

// The hypothesis and the largest of those that touch it, in the order of output: objects first.
std::vector<HypothesisId> GroupAround(const SceneState& state, const ObjectHypothesis& middle) {
  std::vector<const ObjectHypothesis*> touching;
  for (const HypothesisPtr& other : state.hypotheses()) {
    const bool may_touch = other->id != middle.id && IsSmall(*other) && !other->model->is_given &&
                           (!other->IsObject() || other->resting.support == middle.resting.support);
    if (may_touch && Touch(*middle.model, *other->model)) touching.push_back(other.get());
  }
  std::ranges::stable_sort(touching, std::greater(),
                           [](const ObjectHypothesis* other) { return other->points.size(); });
  if (touching.size() > kMaxGroupSize) touching.resize(kMaxGroupSize);
  touching.push_back(&middle);
  std::ranges::sort(touching, {},
                    [&](const ObjectHypothesis* one) { return state.IndexOf(one->id); });
  std::vector<HypothesisId> group;
  for (const ObjectHypothesis* one : touching) group.push_back(one->id);
  return group;
}

Proposal MergeOf(const SceneState& state, const std::vector<HypothesisId>& parts) {
  Proposal proposal;
  for (const HypothesisId id : parts) proposal.consumes.push_back({id});
  proposal.products.push_back(Merged(state, parts));
  return proposal;
}

// The z axes of bounded solids, and of plates, which may be a vessel's floor.
std::vector<Vector3> AxesOf(const SceneState& state, const Proposal& proposal) {
  std::vector<Vector3> axes;
  for (const Consumed& consumed : proposal.consumes) {
    for (const ShapePart& part : state.Get(consumed.id).model->shapes()) {
      if (KindOf(part.shape) == ShapeKind::kSphere) continue;
      axes.emplace_back(part.X_OS.linear().col(2));
    }
  }
  return axes;
}

double ShareOn(const ShapePart& shell, const PointSet& points, const OrientedPoints& all) {
  const PointSet some = Subsampled(points, kMaxComparedPoints);
  const Pose X_SL = shell.X_OS.inverse(Eigen::Isometry);
  const auto on = std::ranges::count_if(some, [&](std::uint32_t i) {
    const Vector3 p = X_SL * all.points[i].cast<double>();
    return std::abs(SignedDistance_m(shell, p)) <= kDistanceGate_sigma * double{all.sigma_m[i]};
  });
  return static_cast<double>(on) / static_cast<double>(some.size());
}

class MergeVesselWalls : public RefinementPass {
 public:
  std::string_view Name() const override { return "merge.vessel_walls"; }
  TrialBudget MaxWork() const override;
  // Proposes to merge each object that may be a part of a lying vessel with the small hypotheses
  // that touch it.
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // Searches the group for the shell of a lying vessel; hypotheses that are not on it are left out.
  std::optional<Proposal> Examine(const SceneState& state, Proposal proposal,
                                  const RefinementContext& context) const override;
  // The product must be one vessel, with handles, that leaves few points unexplained.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

TrialBudget MergeVesselWalls::MaxWork() const {
  return {.note = "parts of a vessel that lies may stand apart: the cap of joins was reached"};
}

std::vector<Proposal> MergeVesselWalls::Propose(const SceneState& state,
                                                const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  if (!SearchesAny(context.options.modeler)) return proposals;
  std::set<std::vector<HypothesisId>> groups;
  for (const HypothesisPtr& hypothesis : state.objects()) {
    context.work.Poll();
    if (!MayBeOfLyingVessel(*hypothesis)) continue;
    const std::vector<HypothesisId> group = GroupAround(state, *hypothesis);
    if (group.size() < 2 || !groups.insert(group).second) continue;
    proposals.push_back(MergeOf(state, group));
  }
  return proposals;
}

std::optional<Proposal> MergeVesselWalls::Examine(const SceneState& state, Proposal proposal,
                                                  const RefinementContext& context) const {
  const Product& merged = proposal.products.front();
  const OrientedPoints points =
      PointSample(state.points(), merged.points, merged.node_count).Points();
  const std::optional<ShapePart> shell =
      FindLyingVessel(points, X_LGround(state.measured(), merged.resting), AxesOf(state, proposal),
                      context.options.noise, context.options.modeler, context.work);
  if (!shell) return std::nullopt;
  std::vector<HypothesisId> parts;
  for (const Consumed& consumed : proposal.consumes) {
    const PointSet& of_part = state.Get(consumed.id).points;
    if (ShareOn(*shell, of_part, state.points()) >= kMainShare) parts.push_back(consumed.id);
  }
  if (parts.size() < 2) return std::nullopt;
  return MergeOf(state, parts);
}

bool MergeVesselWalls::Admits(const SceneState&, const Proposal&, std::size_t,
                              const ObjectModel& found) const {
  const auto left = std::ranges::count(found.part_of_point, kUnexplained);
  return found.shapes.size() == 1 && found.shapes.front().vessel &&
         static_cast<double>(left) <=
             (1 - kNearlyAll) * static_cast<double>(found.part_of_point.size());
}

double MergeVesselWalls::Gain(const ModelledProposal& modelled) const {
  return ExplainsAllParts(modelled) ? static_cast<double>(modelled.proposal.consumes.size() - 1)
                                    : 0;
}

std::unique_ptr<const RefinementPass> MakeMergeVesselWalls() {
  return std::make_unique<const MergeVesselWalls>();
}

}  // namespace cwm::perception
