#include "perception/refinement/split/split_false_handles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/model/handles.h"
#include "perception/model/object_modeler.h"
#include "perception/refinement/evidence.h"

namespace cwm::perception {
namespace {

// measured: no simulated scene asks for more than seven.
constexpr int kMaxTrials = 8;
constexpr double kMinExplained = 0.96;  // of the points: a handle, too, is a bit of a cylinder
// From the ground to the lowest place: noise. measured: balls through handles of vessels are 12 mm off
// and more.
constexpr double kMaxFootGap_m = 0.005;
constexpr double kMinUpright_cos = 0.98;  // 11 degrees: what is known as upright is exactly so

// Products of a proposal.
constexpr std::size_t kHandle = 0, kRest = 1;

// Wider and longer than handles are across. What lies is longer than wide: an ear is as well a bit of a
// coin on edge.
bool IsRoundThing(const ShapePart& part, const Vector3& up) {
  if (part.vessel) return false;
  if (const auto* sphere = std::get_if<Sphere>(&part.shape)) {
    return 2 * sphere->radius_m > kMostSeenHandleWidth_m;
  }
  double radius_m = 0, length_m = 0;
  if (const auto* cylinder = std::get_if<Cylinder>(&part.shape)) {
    radius_m = cylinder->radius_m, length_m = cylinder->length_m;
  } else if (const auto* cone = std::get_if<Cone>(&part.shape)) {
    radius_m = std::max(cone->radius_bottom_m, cone->radius_top_m), length_m = cone->length_m;
  }
  const bool is_upright = std::abs(part.X_OS.linear().col(2).dot(up)) > kMinUpright_cos;
  return std::min(2 * radius_m, length_m) > kMostSeenHandleWidth_m &&
         (is_upright || length_m > 2 * radius_m);
}

// And touches what it stands on.
bool StandsRound(const ShapePart& part, const Pose& X_LFoot) {
  const Pose X_GroundS = X_LFoot.inverse(Eigen::Isometry) * part.X_OS;
  return IsRoundThing(part, X_LFoot.linear().col(2)) &&
         std::abs(TightBounds(part.shape, X_GroundS).min().z()) <= kMaxFootGap_m;
}

ModelingOptions OneObject(ModelingOptions options) {
  options.modeler.part_touching = false;
  return options;
}

}  // namespace

std::span<const std::string_view> SplitFalseHandles::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"reassign.points"};
  return kAfter;
}

Allowance SplitFalseHandles::MaxWork() const {
  return {.max_trials = kMaxTrials,
          .note = "a handle may be an object of its own: the cap of looks was reached"};
}

std::vector<Proposal> SplitFalseHandles::Propose(const SceneState& state,
                                                 const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  for (const HypothesisPtr& object : state.objects()) {
    context.work.Poll();
    if (object->model->is_given) continue;
    for (std::size_t h = 0; h < object->model->handles().size(); ++h) {
      PointSet members = PointsOfHandle(*object, h);
      if (members.empty() || members.size() == object->points.size()) continue;
      Product rest = Without(*object, members);
      Product handle{.node_count = NodesOf(*object, members.size()),
                     .resting = object->resting,
                     .expects = Expectation::kOneObject};
      handle.points = std::move(members);
      proposals.push_back(
          {.consumes = {{object->id, kRest}}, .products = {std::move(handle), std::move(rest)}});
    }
  }
  return proposals;
}

std::optional<Proposal> SplitFalseHandles::Examine(const SceneState& state, Proposal proposal,
                                                   const RefinementContext& context) const {
  const Product& handle = proposal.products[kHandle];
  const Pose X_LFoot = *X_LGround(state.measured(), handle.resting);
  const ModelingOptions options = OneObject(context.options);
  const auto solid = ModelOneSolid(Subset(state.points(), handle.points), X_LFoot, options.noise,
                                   options.modeler, context.work);
  if (!solid || !StandsRound(*solid, X_LFoot)) return std::nullopt;
  return proposal;
}

bool SplitFalseHandles::Admits(const SceneState& state, const Proposal& proposal,
                               std::size_t product, const ObjectModel& found) const {
  if (product == kRest) return true;
  return IsOneSolid(found, kMinExplained) &&
         StandsRound(found.shapes.front(),
                     *X_LGround(state.measured(), proposal.products[kHandle].resting));
}

double SplitFalseHandles::Gain(const SceneState&, const Proposal&,
                               std::span<const ModelPtr>) const {
  return 1;
}

}  // namespace cwm::perception
