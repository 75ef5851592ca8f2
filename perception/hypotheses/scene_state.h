// The hypotheses of one scan at one step of its interpretation.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "perception/hypotheses/object_hypothesis.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {

// The plane that the hypothesis stands on, in the level frame: the top of the support, or of the
// object between, with z = 0 on the plane and z up. Empty for residual geometry.
std::optional<Pose> X_LGround(const SegmentedScene& measured, const Resting& resting);

// An immutable value; a changed state shares all hypotheses that did not change.
class SceneState {
 public:
  // Ids are 0, 1, ... in the order of SegmentedScene::hypotheses. The objects and the points of the
  // supports are moved into the state.
  explicit SceneState(SegmentedScene scene);

  // Points, planes of supports, sight map and rejected points, without objects: they never change.
  const SegmentedScene& measured() const { return *measured_; }
  const OrientedPoints& points() const { return measured_->points; }
  const std::optional<SightMap>& sight() const { return measured_->sight; }
  const SegmentedSupport& support(std::size_t index) const { return *supports_[index]; }
  std::size_t support_count() const { return supports_.size(); }

  // In the order of output: objects, largest first, then residual geometry; ties by id.
  std::span<const HypothesisPtr> hypotheses() const { return hypotheses_; }
  std::span<const HypothesisPtr> objects() const { return hypotheses().first(object_count_); }

  // Null if there is no such hypothesis.
  const ObjectHypothesis* Find(HypothesisId id) const;
  // Precondition: the hypothesis exists.
  const ObjectHypothesis& Get(HypothesisId id) const { return *Find(id); }
  // Index into hypotheses(). Precondition: the hypothesis exists.
  std::size_t IndexOf(HypothesisId id) const;

  // The id that Change::added[k] of the next change will get.
  HypothesisId NextId(std::size_t k) const { return {next_id_ + static_cast<std::uint32_t>(k)}; }

  struct Change {
    std::vector<HypothesisId> removed;
    std::vector<ObjectHypothesis> added;  // With() assigns their ids
    std::vector<std::pair<HypothesisId, Resting>> resting_updates;
    std::vector<std::pair<std::size_t, PointSet>> support_points;  // of changed supports
  };
  // Precondition: `removed` and `resting_updates` exist and have no id in common.
  SceneState With(Change change) const;

  // models[k] becomes the model of hypotheses()[k]; if null, the previous model stays. A hypothesis
  // whose model reaches the support then rests on that only.
  SceneState WithModels(std::span<const ModelPtr> models) const;

 private:
  void Sort();

  std::shared_ptr<const SegmentedScene> measured_;
  std::vector<std::shared_ptr<const SegmentedSupport>> supports_;
  std::vector<HypothesisPtr> hypotheses_;
  std::size_t object_count_ = 0;
  std::uint32_t next_id_ = 0;
};

}  // namespace cwm::perception
