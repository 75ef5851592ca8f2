#include "perception/refinement/attach/attachment.h"

#include <algorithm>
#include <map>
#include <utility>

namespace cwm::perception {
namespace {

// The receivers of hypotheses that are given as a whole.
class Receivers {
 public:
  explicit Receivers(std::span<const PointTransfer> transfers) {
    for (const PointTransfer& transfer : transfers) {
      if (transfer.points.empty()) to_[transfer.from] = transfer.to;
    }
  }
  // The hypothesis that finally receives this one; itself if it stays.
  HypothesisId Last(HypothesisId id) const {
    for (auto next = to_.find(id); next != to_.end(); next = to_.find(id)) id = next->second;
    return id;
  }
  bool Stays(HypothesisId id) const { return !to_.contains(id); }

 private:
  std::map<HypothesisId, HypothesisId> to_;
};

void Move(const PointSet& points, ObjectHypothesis& from, ObjectHypothesis& to) {
  const std::size_t nodes = from.node_count * points.size() / from.points.size();
  from.node_count -= nodes;
  to.node_count += nodes;
  std::erase_if(from.points,
                [&](std::uint32_t i) { return std::ranges::binary_search(points, i); });
  to.points.insert(to.points.end(), points.begin(), points.end());
}

}  // namespace

SceneState Attach(const SceneState& state, std::span<const PointTransfer> transfers) {
  const Receivers receivers(transfers);
  std::map<HypothesisId, ObjectHypothesis> changed;
  const auto open = [&](HypothesisId id) -> ObjectHypothesis& {
    return changed.try_emplace(id, state.Get(id)).first->second;
  };
  for (const PointTransfer& transfer : transfers) {
    if (!transfer.points.empty()) Move(transfer.points, open(transfer.from), open(transfer.to));
  }
  for (const PointTransfer& transfer : transfers) {
    if (transfer.points.empty()) open(transfer.from), open(receivers.Last(transfer.to));
  }
  for (auto& [id, hypothesis] : changed) {
    if (receivers.Stays(id)) continue;
    ObjectHypothesis& receiver = changed.at(receivers.Last(id));
    receiver.points.insert(receiver.points.end(), hypothesis.points.begin(),
                           hypothesis.points.end());
    receiver.node_count += hypothesis.node_count;
  }

  // The changed hypotheses get new ids, in the order of the old ones.
  SceneState::Change change;
  std::map<HypothesisId, HypothesisId> renamed;
  for (auto& [id, hypothesis] : changed) {
    change.removed.push_back(id);
    if (!receivers.Stays(id)) continue;
    renamed[id] = state.NextId(change.added.size());
    std::ranges::sort(hypothesis.points);
    change.added.push_back(hypothesis);
  }
  const auto below = [&](HypothesisId on) {
    const HypothesisId last = receivers.Last(on);
    const auto found = renamed.find(last);
    return found == renamed.end() ? last : found->second;
  };
  for (std::size_t k = 0; k < change.added.size(); ++k) {
    Resting& resting = change.added[k].resting;
    if (resting.on) resting.on = below(*resting.on);
    if (resting.on == state.NextId(k)) resting.on.reset();
  }
  for (const HypothesisPtr& other : state.hypotheses()) {
    if (!other->resting.on || changed.contains(other->id)) continue;
    Resting resting = other->resting;
    resting.on = below(*resting.on);
    if (resting.on != other->resting.on) change.resting_updates.emplace_back(other->id, resting);
  }
  return state.With(std::move(change));
}

}  // namespace cwm::perception
