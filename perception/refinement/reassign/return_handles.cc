#include "perception/refinement/reassign/return_handles.h"

#include <algorithm>

#include "perception/cloud/tolerances.h"
#include "perception/refinement/evidence.h"
#include "perception/refinement/merge/occlusion.h"

namespace cwm::perception {
namespace {

// Indices of a proposal's products.
enum : std::size_t { kFromOwner, kToTaker };

// True if the owner stands on something, and the taker on the same support or on nothing.
bool MayOwn(const ObjectHypothesis& owner, const ObjectHypothesis& taker) {
  if (owner.model->is_given || taker.model->is_given) return false;
  return owner.IsObject() &&
         (!taker.IsObject() || taker.resting.support == owner.resting.support) &&
         owner.model->bounds_L.exteriorDistance(taker.model->bounds_L) <= kMaxHiddenGap_m;
}

// The points of the taker's handles that lie on the owner's only solid or its extension. Ascending.
PointSet HandlesOn(const OrientedPoints& all, const ObjectHypothesis& taker,
                   const ObjectHypothesis& owner) {
  PointSet found;
  if (!IsSingleSolid(owner.model->object, kMainShare)) return found;
  const ShapePart& solid = owner.model->shapes().front();
  if (solid.vessel) return found;
  for (std::size_t h = 0; h < taker.model->handles().size(); ++h) {
    const PointSet members = PointsOfHandle(taker, h);
    const auto on = std::ranges::count_if(members, [&](std::uint32_t i) {
      return IsOnSolid(solid, all, i) || IsOnExtended(solid, all, i);
    });
    if (static_cast<double>(on) < kMainShare * static_cast<double>(members.size())) {
      continue;
    }
    found.insert(found.end(), members.begin(), members.end());
  }
  std::ranges::sort(found);
  return found;
}

class ReturnHandles : public RefinementPass {
 public:
  std::string_view Name() const override { return "reassign.handles"; }
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The owner must stay one solid.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

TrialBudget ReturnHandles::MaxWork() const {
  return {.note = "a handle of it may belong to another object: the cap of returns was reached"};
}

std::vector<Proposal> ReturnHandles::Propose(const SceneState& state,
                                             const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  if (!state.sight()) return proposals;
  for (const HypothesisPtr& taker : state.hypotheses()) {
    if (taker->model->handles().empty()) continue;
    for (const HypothesisPtr& owner : state.objects()) {
      if (owner->id == taker->id || !MayOwn(*owner, *taker)) continue;
      context.work.Poll();
      const PointSet handles = HandlesOn(state.points(), *taker, *owner);
      if (handles.empty() || handles.size() == taker->points.size()) continue;
      if (VisibilityBetween(state, handles, owner->points).IsContradicted()) continue;
      const std::size_t nodes = NodesOf(*taker, handles.size());
      proposals.push_back({.consumes = {{owner->id, kFromOwner}, {taker->id, kToTaker}},
                           .products = {With(*owner, handles, nodes), Without(*taker, handles)}});
    }
  }
  return proposals;
}

bool ReturnHandles::Admits(const SceneState&, const Proposal&, std::size_t product,
                           const ObjectModel& found) const {
  return product == kToTaker || IsSingleSolid(found);
}

// The number of points that the owner received and its solid explains, if that is most of them;
// else 0.
double ReturnHandles::Gain(const ModelledProposal& modelled) const {
  const PointSet& before = modelled.state.Get(modelled.proposal.consumes[kFromOwner].id).points;
  const PointSet& after = modelled.proposal.products[kFromOwner].points;
  std::size_t got = 0, explained = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    if (std::ranges::binary_search(before, after[k])) continue;
    ++got;
    explained += modelled.products[kFromOwner]->part_of_point()[k] == 0;
  }
  const bool accounts = static_cast<double>(explained) >= kMainShare * static_cast<double>(got);
  return accounts ? static_cast<double>(explained) : 0;
}

std::unique_ptr<const RefinementPass> MakeReturnHandles() {
  return std::make_unique<const ReturnHandles>();
}

}  // namespace cwm::perception
