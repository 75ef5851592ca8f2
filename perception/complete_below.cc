#include "perception/complete_below.h"

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <numbers>

#include "collision/geometry/aabb.h"
#include "perception/complete_hidden.h"

namespace cwm::perception {
namespace {

// What ends nearer to what it carries has its upper end seen: a crease takes as much of it.
constexpr double kLeastGap_m = 0.01;

// The foot of what it carries, seen from there: z down.
Pose FootFromAbove(const SegmentedScene& scene, const SegmentedThing& upper) {
  Pose X_LFoot = *WhatItStandsOn(scene, upper);
  X_LFoot.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()));
  return X_LFoot;
}

void ReachUpTo(const Pose& X_LFoot, const SegmentedScene& scene, const SegmentedThing& lower,
               ModelledThing& thing) {
  if (thing.model->shapes.size() != 1 || thing.model->shapes.front().vessel) return;
  std::vector<ShapePart> shapes = thing.model->shapes;
  ShapePart& part = shapes.front();
  part.X_OS = thing.X_LO * part.X_OS;
  const Pose X_FootS = X_LFoot.inverse(Eigen::Isometry) * part.X_OS;
  if (TightBounds(part.shape, X_FootS).min().z() < kLeastGap_m) return;
  CompleteHidden({Subset(scene.points, lower.points), X_LFoot}, *scene.sight, shapes);
  part.X_OS = thing.X_LO.inverse(Eigen::Isometry) * part.X_OS;
  auto model = std::make_shared<HybridModel>(*thing.model);
  model->shapes = std::move(shapes);
  thing.model = std::move(model);
}

}  // namespace

void CompleteBelow(const SegmentedScene& scene, std::vector<ModelledThing>& modelled) {
  if (!scene.sight) return;
  for (const SegmentedThing& upper : scene.things) {
    if (upper.rests_on < 0 || upper.supported_by < 0) continue;
    const auto lower = static_cast<std::size_t>(upper.rests_on);
    ReachUpTo(FootFromAbove(scene, upper), scene, scene.things[lower], modelled[lower]);
  }
}

}  // namespace cwm::perception
