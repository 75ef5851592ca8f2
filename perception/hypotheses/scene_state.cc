#include "perception/hypotheses/scene_state.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace cwm::perception {
namespace {

void StandOnSupport(Resting& resting) {
  resting.on.reset();
  resting.foot_height_m = 0;
}

}  // namespace

std::optional<Pose> X_LGround(const SegmentedScene& measured, const Resting& resting) {
  if (resting.support < 0) return std::nullopt;
  Pose X_LGround = measured.supports[static_cast<std::size_t>(resting.support)].plate.X_FS;
  X_LGround.translate(Vector3(0, 0, resting.foot_height_m));
  return X_LGround;
}

SceneState::SceneState(SegmentedScene scene) {
  for (SegmentedHypothesis& segmented : scene.hypotheses) {
    auto hypothesis = std::make_shared<ObjectHypothesis>();
    hypothesis->id = {next_id_++};
    hypothesis->points = std::move(segmented.points);
    if (!std::ranges::is_sorted(hypothesis->points)) std::ranges::sort(hypothesis->points);
    hypothesis->node_count = segmented.node_count;
    hypothesis->resting.support = segmented.supported_by;
    hypothesis->resting.foot_height_m = segmented.foot_height_m;
    if (segmented.rests_on >= 0) {
      hypothesis->resting.on = HypothesisId{static_cast<std::uint32_t>(segmented.rests_on)};
    }
    hypothesis->plates = std::move(segmented.plates);
    hypotheses_.push_back(std::move(hypothesis));
  }
  scene.hypotheses.clear();
  for (SegmentedSupport& support : scene.supports) {
    supports_.push_back(std::make_shared<const SegmentedSupport>(
        SegmentedSupport{support.plate, std::exchange(support.points, {})}));
  }
  measured_ = std::make_shared<const SegmentedScene>(std::move(scene));
  Sort();
}

const ObjectHypothesis* SceneState::Find(HypothesisId id) const {
  const auto found = std::ranges::find_if(
      hypotheses_, [&](const HypothesisPtr& hypothesis) { return hypothesis->id == id; });
  return found == hypotheses_.end() ? nullptr : found->get();
}

std::size_t SceneState::IndexOf(HypothesisId id) const {
  const auto found = std::ranges::find_if(
      hypotheses_, [&](const HypothesisPtr& hypothesis) { return hypothesis->id == id; });
  return static_cast<std::size_t>(found - hypotheses_.begin());
}

SceneState SceneState::With(Change change) const {
  SceneState after = *this;
  std::erase_if(after.hypotheses_, [&](const HypothesisPtr& hypothesis) {
    return std::ranges::count(change.removed, hypothesis->id) > 0;
  });
  for (HypothesisPtr& hypothesis : after.hypotheses_) {
    const auto update = std::ranges::find(change.resting_updates, hypothesis->id,
                                          &std::pair<HypothesisId, Resting>::first);
    if (update == change.resting_updates.end()) continue;
    auto moved = std::make_shared<ObjectHypothesis>(*hypothesis);
    moved->resting = update->second;
    hypothesis = std::move(moved);
  }
  for (ObjectHypothesis& added : change.added) {
    added.id = {after.next_id_++};
    after.hypotheses_.push_back(std::make_shared<const ObjectHypothesis>(std::move(added)));
  }
  for (auto& [support, points] : change.support_points) {
    after.supports_[support] = std::make_shared<const SegmentedSupport>(
        SegmentedSupport{supports_[support]->plate, std::move(points)});
  }
  after.Sort();
  return after;
}

SceneState SceneState::WithModels(std::span<const ModelPtr> models) const {
  SceneState after = *this;
  for (std::size_t k = 0; k < models.size(); ++k) {
    if (!models[k]) continue;
    auto modelled = std::make_shared<ObjectHypothesis>(*hypotheses_[k]);
    modelled->model = models[k];
    if (models[k]->reaches_support) StandOnSupport(modelled->resting);
    after.hypotheses_[k] = std::move(modelled);
  }
  return after;
}

void SceneState::Sort() {
  const auto key = [](const HypothesisPtr& hypothesis) {
    const std::size_t size = hypothesis->IsObject() ? hypothesis->node_count : 0;
    return std::tuple(!hypothesis->IsObject(), -static_cast<std::ptrdiff_t>(size), hypothesis->id);
  };
  std::ranges::sort(hypotheses_, {}, key);
  object_count_ = static_cast<std::size_t>(std::ranges::count_if(
      hypotheses_, [](const HypothesisPtr& hypothesis) { return hypothesis->IsObject(); }));
}

}  // namespace cwm::perception
