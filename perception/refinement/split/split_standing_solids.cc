#include "perception/refinement/split/split_standing_solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/refinement/evidence.h"
#include "perception/segmentation/disjoint_sets.h"

namespace cwm::perception {
namespace {

// derived: the gap to the top of a lower object that the foot hides: neither end was seen.
constexpr double kMaxStackedGap_m = kMaxContactGap_m * 2;
// chosen: the largest step between surfaces of one object, bent like soft packages, and warped by
// the sensor.
constexpr double kMaxStep_m = 0.005;

bool IsVessel(const ShapePart& part) { return part.vessel != nullptr; }

// True if the model is one solid, or one vessel with its handles.
bool IsSingleObject(const ObjectModel& found) {
  if (IsSingleSolid(found)) return true;
  const auto explained = std::ranges::count_if(
      found.part_of_point, [](std::int32_t part) { return part != kUnexplained; });
  return found.shapes.size() == 1 && IsVessel(found.shapes.front()) &&
         static_cast<double>(explained) >=
             kNearlyAll * static_cast<double>(found.part_of_point.size());
}

bool IsPartOfOneRod(const Cylinder& a, const Pose& X_OA, const Cylinder& b, const Pose& X_OB) {
  const Vector3 axis_a = X_OA.linear().col(2), axis_b = X_OB.linear().col(2);
  const double turn_cos = axis_a.dot(axis_b);
  const Vector3 between = (axis_a + (turn_cos < 0 ? -1 : 1) * axis_b).normalized();
  const Vector3 across = X_OB.translation() - X_OA.translation();
  return std::abs(a.radius_m - b.radius_m) < kMaxStep_m && std::abs(turn_cos) > kAligned_cos &&
         across.cross(between).norm() < kMaxAxisOffset_m;
}

// True for shells about one axis: the axis of each runs within the other.
bool IsPartOfOneVessel(const Aabb& a, const Aabb& b) {
  const double across_m = (a.center() - b.center()).head<2>().norm();
  return across_m < 0.5 * std::min(a.sizes().head<2>().minCoeff(), b.sizes().head<2>().minCoeff());
}

// True for boxes with parallel faces and tops at one height. Their contact and their feet are not
// compared.
bool IsPartOfOneBlock(const Box& a, const Pose& X_SupportA, const Box& b, const Pose& X_SupportB) {
  const auto top_m = [](const Box& box, const Pose& X_SupportB) {
    return TightBounds(box, X_SupportB).max().z();
  };
  const Matrix3 turns = (X_SupportA.linear().transpose() * X_SupportB.linear()).cwiseAbs();
  return std::abs(top_m(a, X_SupportA) - top_m(b, X_SupportB)) < kMaxStep_m &&
         turns.rowwise().maxCoeff().minCoeff() > kAligned_cos;
}

// The objects made of the solids, if they stand on the object's ground or on each other.
struct StandingObjects {
  std::vector<std::size_t> of_solid;  // per solid, the index of its object
  std::vector<std::size_t> below;     // per object, the one it rests on; itself: the ground
  std::vector<double> foot_m;         // the height of that
};

// The solid that this one rests on, or itself if it stands on the ground; empty if neither. Only
// boxes are stacked: a round solid on another one is its neck, lid or knob.
std::optional<std::size_t> Below(std::size_t solid, const std::vector<ShapePart>& shapes,
                                 const std::vector<Aabb>& bounds, const Pose& X_GroundL) {
  const double foot_m = bounds[solid].min().z();
  if (std::abs(foot_m) <= kMaxContactGap_m) return solid;
  if (!std::holds_alternative<Box>(shapes[solid].shape)) return std::nullopt;
  Vector3 under = bounds[solid].center();
  for (std::size_t other = 0; other < shapes.size(); ++other) {
    const double top_m = bounds[other].max().z();
    if (other == solid || !std::holds_alternative<Box>(shapes[other].shape) ||
        std::abs(foot_m - top_m) > kMaxStackedGap_m) {
      continue;
    }
    under.z() = top_m - kMaxContactGap_m;
    const Pose X_OtherSupport = (X_GroundL * shapes[other].X_OS).inverse(Eigen::Isometry);
    if (SignedDistance_m(shapes[other], X_OtherSupport * under) < 0) return other;
  }
  return std::nullopt;
}

// The solids that may be objects: the closed ones, or all shapes if all are vessels; none if only
// some are vessels. Points of single faces go to the nearest solid.
std::vector<std::size_t> SolidsOf(const std::vector<ShapePart>& shapes) {
  std::vector<std::size_t> closed;
  std::size_t vessels = 0;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    vessels += IsVessel(shapes[k]);
    if (IsClosed(shapes[k])) closed.push_back(k);
  }
  if (vessels == 0) return closed;
  if (vessels < shapes.size()) return {};
  std::vector<std::size_t> all(shapes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

std::optional<StandingObjects> FindStandingObjects(const std::vector<ShapePart>& shapes,
                                                   const Pose& X_GroundL) {
  if (shapes.size() < 2) return std::nullopt;
  std::vector<Aabb> bounds;
  for (const ShapePart& part : shapes) {
    bounds.push_back(TightBounds(part.shape, X_GroundL * part.X_OS));
  }
  std::vector<std::size_t> below;
  bool is_stack = false;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const std::optional<std::size_t> found = Below(k, shapes, bounds, X_GroundL);
    if (!found) return std::nullopt;
    is_stack |= *found != k;
    below.push_back(*found);
  }
  DisjointSets sets(shapes.size());
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    for (std::size_t b = a + 1; b < shapes.size(); ++b) {
      if (!ContinuesSurface(shapes[a], shapes[b], X_GroundL)) continue;
      // Closed solids side by side are then one object, and nothing is split. In a stack, or of
      // vessels, only these two are one object.
      if (!is_stack && !IsVessel(shapes[a])) return std::nullopt;
      sets.Join(a, b);
    }
  }
  StandingObjects standing{std::vector<std::size_t>(shapes.size()), {}, {}};
  std::vector<std::size_t> first;  // first solid of each object
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (sets.Root(k) == k) standing.of_solid[k] = first.size(), first.push_back(k);
    standing.of_solid[k] = standing.of_solid[sets.Root(k)];
  }
  if (first.size() < 2) return std::nullopt;
  for (std::size_t solid : first) {
    standing.below.push_back(standing.of_solid[below[solid]]);
    standing.foot_m.push_back(below[solid] == solid ? 0 : bounds[below[solid]].max().z());
  }
  return standing;
}

// The points of each object, with points without a solid that are nearest to it. Ascending.
std::vector<PointSet> PointsPerObject(const ObjectHypothesis& object,
                                      const std::vector<std::size_t>& solids,
                                      const std::vector<ShapePart>& shapes,
                                      const StandingObjects& standing, const OrientedPoints& all) {
  std::vector<PointSet> groups(standing.below.size());
  for (std::size_t i = 0; i < object.points.size(); ++i) {
    const auto part = static_cast<std::size_t>(object.model->part_of_point()[i]);
    const auto own = std::ranges::find(solids, part);
    const std::size_t solid =
        own != solids.end() ? static_cast<std::size_t>(own - solids.begin())
                            : NearestShape(shapes, all.points[object.points[i]].cast<double>());
    groups[standing.of_solid[solid]].push_back(object.points[i]);
  }
  return groups;
}

// The foot of a hypothesis, below the middle of its points.
Vector3 FootOf(const SceneState& state, const ObjectHypothesis& hypothesis) {
  Vector3 middle_L = Vector3::Zero();
  for (std::uint32_t i : hypothesis.points) middle_L += state.points().points[i].cast<double>();
  const Pose X_LFoot = *X_LGround(state.measured(), hypothesis.resting);
  Vector3 foot =
      X_LFoot.inverse(Eigen::Isometry) * (middle_L / static_cast<double>(hypothesis.points.size()));
  foot.z() = 0;
  return X_LFoot * foot;
}

// One product per object. What rested on the split object rests on the product nearest to its foot.
Proposal SplitOf(const SceneState& state, const ObjectHypothesis& object,
                 const std::vector<ShapePart>& shapes, const StandingObjects& standing,
                 std::vector<PointSet> groups) {
  Proposal proposal{.consumes = {{object.id}}};
  for (std::size_t k = 0; k < groups.size(); ++k) {
    Product product{.points = std::move(groups[k]),
                    .resting = object.resting,
                    .expects = Expectation::kSingleObject};
    product.node_count = NodesOf(object, product.points.size());
    if (standing.below[k] != k) {
      product.on_product = standing.below[k];
      product.resting.foot_height_m = object.resting.foot_height_m + standing.foot_m[k];
    }
    proposal.products.push_back(std::move(product));
  }
  for (const HypothesisPtr& other : state.objects()) {
    if (other->resting.on != object.id) continue;
    const std::size_t solid = NearestShape(shapes, FootOf(state, *other));
    proposal.resting_updates.push_back({other->id, standing.of_solid[solid], {}});
  }
  return proposal;
}

class SplitStandingSolids : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.standing_solids"; }
  std::span<const std::string_view> After() const override;
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The product must be one solid, or one vessel with handles.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

bool ContinuesSurface(const ShapePart& part, const ShapePart& other, const Pose& X_GroundL) {
  const Pose X_SupportA = X_GroundL * part.X_OS, X_SupportB = X_GroundL * other.X_OS;
  if (IsVessel(part) && IsVessel(other)) {
    return IsPartOfOneVessel(TightBounds(part.shape, X_SupportA),
                             TightBounds(other.shape, X_SupportB));
  }
  if (const auto* a = std::get_if<Cylinder>(&part.shape), *b = std::get_if<Cylinder>(&other.shape);
      a && b) {
    return IsPartOfOneRod(*a, X_SupportA, *b, X_SupportB);
  }
  if (const auto* a = std::get_if<Box>(&part.shape), *b = std::get_if<Box>(&other.shape); a && b) {
    return IsPartOfOneBlock(*a, X_SupportA, *b, X_SupportB);
  }
  return false;
}

std::span<const std::string_view> SplitStandingSolids::After() const {
  static constexpr std::array<std::string_view, 2> kAfter = {"merge.occluded_parts",
                                                             "reassign.points"};
  return kAfter;
}

TrialBudget SplitStandingSolids::MaxWork() const {
  return {.max_trials = kMaxTrials,
          .note = "its shapes may be objects of their own: the cap of points of parts was reached"};
}

std::vector<Proposal> SplitStandingSolids::Propose(const SceneState& state,
                                                   const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  for (const HypothesisPtr& object : state.objects()) {
    context.work.Poll();
    if (object->model->is_given) continue;
    const Pose X_GroundL = X_LGround(state.measured(), object->resting)->inverse(Eigen::Isometry);
    const std::vector<std::size_t> solids = SolidsOf(object->model->shapes());
    std::vector<ShapePart> shapes;
    for (const std::size_t k : solids) shapes.push_back(object->model->shapes()[k]);
    const auto standing = FindStandingObjects(shapes, X_GroundL);
    if (!standing) continue;
    std::vector<PointSet> groups =
        PointsPerObject(*object, solids, shapes, *standing, state.points());
    if (std::ranges::any_of(groups, [](const PointSet& group) { return group.empty(); })) continue;
    proposals.push_back(SplitOf(state, *object, shapes, *standing, std::move(groups)));
  }
  return proposals;
}

bool SplitStandingSolids::Admits(const SceneState&, const Proposal&, std::size_t,
                                 const ObjectModel& found) const {
  return IsSingleObject(found);
}

double SplitStandingSolids::Gain(const ModelledProposal& modelled) const {
  return static_cast<double>(modelled.proposal.products.size() - 1);
}

std::unique_ptr<const RefinementPass> MakeSplitStandingSolids() {
  return std::make_unique<const SplitStandingSolids>();
}

}  // namespace cwm::perception
