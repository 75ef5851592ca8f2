#include "perception/refinement/merge/merge_occluded_parts.h"

#include <algorithm>
#include <array>

#include "collision/geometry/aabb.h"
#include "perception/cloud/tolerances.h"
#include "perception/refinement/evidence.h"
#include "perception/refinement/merge/occlusion.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

// True if one shape explains at least kMainShare of the points. That is less than for other solids
// (kNearlyAll), to allow for edges; true parts of occluded objects reached it.
bool IsNearlyOneSolid(const ObjectHypothesis& hypothesis) {
  return IsSingleSolid(hypothesis.model->object, kMainShare);
}

// True if `lid` is a single face that rests on the other one. An occluder may leave a lid and a
// separate strip of the wall of a cup visible, and an extended cup is not a cylinder.
bool IsLidOn(const ObjectHypothesis& lid, const ObjectHypothesis& other) {
  if (lid.resting.on != other.id || !IsNearlyOneSolid(lid)) return false;
  const Aabb bounds_S = TightBounds(lid.model->shapes().front().shape, Pose::Identity());
  return bounds_S.sizes().minCoeff() <= kMaxLoneThickness_m;
}

// True if `one` is a solid whose extension explains the other one. Vessels cannot be extended.
bool ExtendsTo(const SceneState& state, const ObjectHypothesis& one,
               const ObjectHypothesis& other) {
  if (!IsNearlyOneSolid(one)) return false;
  const ShapePart& solid = one.model->shapes().front();
  if (solid.vessel) return false;
  const PointSet sample = Subsampled(other.points, kMaxTestedPoints);
  const auto on = std::ranges::count_if(
      sample, [&](std::uint32_t i) { return IsOnExtended(solid, state.points(), i); });
  return static_cast<double>(on) >= kMajority * static_cast<double>(sample.size());
}

bool MayBeOne(const SceneState& state, const ObjectHypothesis& a, const ObjectHypothesis& b) {
  if (a.model->is_given || b.model->is_given) return false;
  if (a.resting.support != b.resting.support) return false;
  if (a.model->bounds_L.exteriorDistance(b.model->bounds_L) > kMaxHiddenGap_m) return false;
  const bool suggests =
      ExtendsTo(state, a, b) || ExtendsTo(state, b, a) || IsLidOn(a, b) || IsLidOn(b, a);
  return suggests && VisibilityBetween(state, a.points, b.points).IsHidden();
}

class MergeOccludedParts : public RefinementPass {
 public:
  std::string_view Name() const override { return "merge.occluded_parts"; }
  std::span<const std::string_view> After() const override;
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The product must be one solid.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

std::span<const std::string_view> MergeOccludedParts::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"reassign.handles"};
  return kAfter;
}

TrialBudget MergeOccludedParts::MaxWork() const {
  return {.note = "parts of it may stand apart: the cap of joins was reached"};
}

std::vector<Proposal> MergeOccludedParts::Propose(const SceneState& state,
                                                  const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  if (!state.sight()) return proposals;
  const auto objects = state.objects();
  for (std::size_t a = 0; a < objects.size(); ++a) {
    context.work.Poll();
    for (std::size_t b = a + 1; b < objects.size(); ++b) {
      if (!MayBeOne(state, *objects[a], *objects[b])) continue;
      const std::array both = {objects[a]->id, objects[b]->id};
      proposals.push_back({.consumes = {{both[0]}, {both[1]}}, .products = {Merged(state, both)}});
    }
  }
  return proposals;
}

bool MergeOccludedParts::Admits(const SceneState&, const Proposal&, std::size_t,
                                const ObjectModel& found) const {
  return IsSingleSolid(found);
}

double MergeOccludedParts::Gain(const ModelledProposal& modelled) const {
  return ExplainsAllParts(modelled) ? static_cast<double>(modelled.proposal.consumes.size() - 1)
                                    : 0;
}

std::unique_ptr<const RefinementPass> MakeMergeOccludedParts() {
  return std::make_unique<const MergeOccludedParts>();
}

}  // namespace cwm::perception
