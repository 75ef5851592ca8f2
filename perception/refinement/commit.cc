#include "perception/refinement/commit.h"

#include <algorithm>
#include <iterator>
#include <optional>

namespace cwm::perception {
namespace {

const Consumed* FindConsumed(const Proposal& proposal, std::optional<HypothesisId> id) {
  if (!id) return nullptr;
  const auto found = std::ranges::find(proposal.consumes, *id, &Consumed::id);
  return found == proposal.consumes.end() ? nullptr : &*found;
}

// The hypothesis that the k-th product rests on in the new state.
std::optional<HypothesisId> Below(const SceneState& state, const Proposal& proposal,
                                  std::size_t k) {
  const Product& product = proposal.products[k];
  if (product.on_product) return state.NextId(*product.on_product);
  const Consumed* const consumed = FindConsumed(proposal, product.resting.on);
  if (consumed == nullptr) return product.resting.on;
  if (consumed->successor == k) return std::nullopt;
  return state.NextId(consumed->successor);
}

}  // namespace

ObjectHypothesis HypothesisOf(const Product& product) {
  ObjectHypothesis hypothesis;
  hypothesis.points = product.points;
  hypothesis.node_count = product.node_count;
  hypothesis.resting = product.resting;
  hypothesis.plates = product.plates;
  return hypothesis;
}

SceneState Commit(const SceneState& state, const Proposal& proposal,
                  std::span<const ModelPtr> models) {
  SceneState::Change change;
  for (const Consumed& consumed : proposal.consumes) change.removed.push_back(consumed.id);
  for (std::size_t k = 0; k < proposal.products.size(); ++k) {
    ObjectHypothesis& added = change.added.emplace_back(HypothesisOf(proposal.products[k]));
    added.resting.on = Below(state, proposal, k);
    added.model = models[k];
    if (models[k]->reaches_support) {
      added.resting.on.reset();
      added.resting.foot_height_m = 0;
    }
  }
  for (const HypothesisPtr& other : state.hypotheses()) {
    if (FindConsumed(proposal, other->id) != nullptr) continue;
    Resting resting = other->resting;
    const auto update = std::ranges::find(proposal.resting_updates, other->id, &RestingUpdate::id);
    if (update != proposal.resting_updates.end()) {
      resting.on = state.NextId(update->on_product);
      resting.foot_height_m = update->foot_height_m.value_or(resting.foot_height_m);
    } else if (const Consumed* const below = FindConsumed(proposal, resting.on)) {
      resting.on = state.NextId(below->successor);
    } else {
      continue;
    }
    change.resting_updates.emplace_back(other->id, resting);
  }
  if (proposal.from_support) {
    const std::size_t support = proposal.from_support->support;
    const PointSet& taken = proposal.from_support->points;
    PointSet left;
    std::ranges::copy_if(state.support(support).points, std::back_inserter(left),
                         [&](std::uint32_t i) { return !std::ranges::binary_search(taken, i); });
    change.support_points.emplace_back(support, std::move(left));
  }
  return state.With(std::move(change));
}

}  // namespace cwm::perception
