// The hypotheses of one scan at one moment of its interpretation.
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

// The top of the support, or of what lies between, in the level frame: z = 0 is the plane on which
// the hypothesis stands, z points up. Null for residual geometry.
std::optional<Pose> X_LGround(const SegmentedScene& measured, const Resting& resting);

// An immutable value; a changed state shares all hypotheses that the change leaves alone.
class SceneState {
 public:
  // The hypotheses have the ids 0, 1, ... in the order of SegmentedScene::things. The things and the
  // points of the supports move into the state.
  explicit SceneState(SegmentedScene scene);

  // Points, planes of supports, sight and rejected points, without things: they never change.
  const SegmentedScene& measured() const { return *measured_; }
  const OrientedPoints& points() const { return measured_->points; }
  const std::optional<SightMap>& sight() const { return measured_->sight; }
  const SegmentedSupport& support(std::size_t index) const { return *supports_[index]; }
  std::size_t support_count() const { return supports_.size(); }

  // The order of output: objects, largest first, then residual geometry; by id where that ties.
  std::span<const HypothesisPtr> hypotheses() const { return hypotheses_; }
  std::span<const HypothesisPtr> objects() const { return hypotheses().first(object_count_); }

  // Null where no such hypothesis lives.
  const ObjectHypothesis* Find(HypothesisId id) const;
  // Precondition: it lives.
  const ObjectHypothesis& Get(HypothesisId id) const { return *Find(id); }
  // Place in hypotheses(). Precondition: it lives.
  std::size_t IndexOf(HypothesisId id) const;

  // The id that Change::added[k] of the next change gets.
  HypothesisId NextId(std::size_t k) const { return {next_id_ + static_cast<std::uint32_t>(k)}; }

  struct Change {
    std::vector<HypothesisId> removed;
    std::vector<ObjectHypothesis> added;  // their ids are assigned
    std::vector<std::pair<HypothesisId, Resting>> reseated;
    std::vector<std::pair<std::size_t, PointSet>> support_points;  // of changed supports
  };
  // Precondition: `removed` and `reseated` live and share no id.
  SceneState With(Change change) const;

  // models[k] becomes the model of hypotheses()[k]; null keeps what it had. A hypothesis whose model
  // reaches the support rests on nothing else from then on.
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
