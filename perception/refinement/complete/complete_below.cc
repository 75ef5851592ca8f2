#include "perception/refinement/complete/complete_below.h"

#include <Eigen/Geometry>
#include <memory>
#include <numbers>

#include "collision/geometry/aabb.h"
#include "perception/hypotheses/complete_hidden.h"
#include "perception/refinement/evidence.h"

namespace cwm::perception {
namespace {

// The ground plane of the upper object, seen from above: z points down.
Pose FootFromAbove(const SceneState& state, const ObjectHypothesis& upper) {
  Pose X_LFoot = *X_LGround(state.measured(), upper.resting);
  X_LFoot.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()));
  return X_LFoot;
}

}  // namespace

ModelPtr CompleteBelow(const SceneState& state, const ObjectHypothesis& hypothesis) {
  if (!state.sight() || !hypothesis.model) return nullptr;
  const std::vector<ShapePart>& found = hypothesis.model->shapes();
  if (found.size() != 1 || found.front().vessel) return nullptr;
  std::shared_ptr<HypothesisModel> completed;
  for (const HypothesisPtr& upper : state.objects()) {
    if (upper->resting.on != hypothesis.id) continue;
    if (!completed) completed = std::make_shared<HypothesisModel>(*hypothesis.model);
    const Pose X_LFoot = FootFromAbove(state, *upper);
    std::vector<ShapePart>& shapes = completed->object.shapes;
    const Pose X_FootS = X_LFoot.inverse(Eigen::Isometry) * shapes.front().X_OS;
    // If a solid touches the upper object, its upper end was seen.
    if (TightBounds(shapes.front().shape, X_FootS).min().z() < kMaxContactGap_m) continue;
    CompleteHidden({Subset(state.points(), hypothesis.points), X_LFoot}, *state.sight(), shapes);
  }
  return completed;
}

}  // namespace cwm::perception
