// One object as perception assumes it: its points, what it rests on, and the shapes that explain
// it. The same type is used from segmentation to output.
#pragma once

#include <Eigen/Geometry>
#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "collision/geometry/shape.h"
#include "perception/model/object_model.h"

namespace cwm::perception {

// Indices into SegmentedScene::points, ascending. Consecutive points lie near each other, in the
// order of an image, or cell by cell.
using PointSet = std::vector<std::uint32_t>;

// A hypothesis keeps its id as long as it exists; an id is never used twice in a scene.
struct HypothesisId {
  std::uint32_t value = 0;
  friend auto operator<=>(const HypothesisId&, const HypothesisId&) = default;
};

struct Resting {
  std::int32_t support = -1;  // index of a support; -1: residual geometry, on nothing known
  std::optional<HypothesisId> on =
      {};                    // the hypothesis between it and the support, if there is one
  double foot_height_m = 0;  // height of the foot above the top of the support
};

// The shapes that explain a hypothesis, in the level frame.
struct HypothesisModel {
  ObjectModel object;  // part_of_point has an entry for each point of the hypothesis
  // The shapes stand on the support itself: the object that seemed to carry them only hides their
  // foot.
  bool reaches_support = false;
  // A pass supplied the shapes, like those of a tray. No pass consumes such a hypothesis.
  bool is_given = false;
  // Modelled with reduced effort, in a scene with too many objects: its mesh is coarser.
  bool is_reduced_effort = false;
  std::vector<Eigen::Vector3f> thinned_L;  // points, as DetectedObject::points_L
  Eigen::AlignedBox3f bounds_L;            // of thinned_L

  const std::vector<ShapePart>& shapes() const { return object.shapes; }
  const std::vector<Handle>& handles() const { return object.handles; }
  const std::vector<std::int32_t>& part_of_point() const { return object.part_of_point; }
};

// Immutable once it is part of a SceneState.
struct ObjectHypothesis {
  HypothesisId id;
  PointSet points;
  std::size_t node_count = 0;  // pixels or cells with these points: the visible size
  Resting resting;
  // The plates of a wall or front, with holes where rays pass, in the level frame; largest first.
  std::vector<Placed<Plate>> plates;
  std::shared_ptr<const HypothesisModel> model;  // null before modelling

  bool IsObject() const { return resting.support >= 0; }  // not residual geometry
};

using HypothesisPtr = std::shared_ptr<const ObjectHypothesis>;
using ModelPtr = std::shared_ptr<const HypothesisModel>;

}  // namespace cwm::perception
