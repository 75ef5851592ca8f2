#include "perception/refinement/split/split_stacked_rounds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "collision/geometry/aabb.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/refinement/evidence.h"
#include "perception/refinement/split/wall_profile.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

// chosen: the lowest tins and the slimmest cups that are stacked; lids, knobs and necks are
// smaller.
constexpr double kMinStorey_m = 0.022, kMinWidth_m = 0.036;

// The common upright axis of the object's cylinders and cones, as a place in the plane of the
// ground. Empty if they have fewer than half of the points, if their axes differ, or with a vessel.
std::optional<Vector2> AxisOf(const HypothesisModel& model, const Pose& X_GroundL) {
  std::vector<std::size_t> points(model.shapes().size(), 0);
  for (const std::int32_t part : model.part_of_point()) {
    if (part >= 0 && static_cast<std::size_t>(part) < points.size()) {
      ++points[static_cast<std::size_t>(part)];
    }
  }
  std::size_t round = 0, max_points = 0;
  std::optional<Vector2> axis;
  std::vector<Vector2> axes;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const ShapePart& part = model.shapes()[k];
    if (part.vessel) return std::nullopt;
    const bool is_round =
        std::holds_alternative<Cylinder>(part.shape) || std::holds_alternative<Cone>(part.shape);
    const Pose X_GroundS = X_GroundL * part.X_OS;
    if (!is_round || std::abs(X_GroundS.linear()(2, 2)) < kAligned_cos) continue;
    axes.emplace_back(X_GroundS.translation().head<2>());
    round += points[k];
    if (points[k] > max_points) max_points = points[k], axis = axes.back();
  }
  if (2 * round < model.part_of_point().size()) return std::nullopt;
  const auto is_on_it = [&](const Vector2& other) {
    return (other - *axis).norm() < kMaxAxisOffset_m;
  };
  return std::ranges::all_of(axes, is_on_it) ? axis : std::nullopt;
}

// Distances of the wall's points from the axis, by height.
std::vector<ProfilePoint> ProfileOf(const SceneState& state, const ObjectHypothesis& object,
                                    const Pose& X_GroundL, const Vector2& axis) {
  const OrientedPoints& all = state.points();
  const Eigen::Vector3f up = X_GroundL.linear().row(2).transpose().cast<float>();
  ProfileBuilder wall(double{all.points_per_sample});
  for (const std::uint32_t i : object.points) {
    if (!(std::abs(all.normals[i].dot(up)) <= kWallRise_sin)) continue;
    const Vector3 p = X_GroundL * all.points[i].cast<double>();
    if (p.z() >= 0) wall.Add(p.z(), (p.head<2>() - axis).norm(), double{all.sigma_m[i]});
  }
  return wall.Profile();
}

// Seams between storeys that could stand alone; other parts stay with the storey below.
std::vector<double> StoreySeams(std::span<const ProfilePoint> profile) {
  std::vector<double> seams;
  double foot_m = 0;
  const auto could_stand = [&](double low_m, double high_m) {
    if (high_m - low_m < kMinStorey_m) return false;
    std::vector<double> radii_m;
    for (const ProfilePoint& p : profile) {
      if (p.along_m > low_m && p.along_m < high_m) radii_m.push_back(p.offset_m);
    }
    return !radii_m.empty() && 2 * Quantile(std::move(radii_m), 0.5) >= kMinWidth_m;
  };
  const std::vector<double> found = SeamsOf(profile);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double top_m = k + 1 < found.size() ? found[k + 1] : profile.back().along_m;
    if (!could_stand(foot_m, found[k]) || !could_stand(found[k], top_m)) continue;
    seams.push_back(found[k]);
    foot_m = found[k];
  }
  return seams;
}

// The points of each storey: those from one seam up to the next. Points of a level top belong to
// the storey that it ends, even if noise puts them above the seam.
std::vector<PointSet> StoreysOf(const SceneState& state, const ObjectHypothesis& object,
                                const Pose& X_GroundL, const std::vector<double>& seams) {
  const OrientedPoints& all = state.points();
  const Eigen::Vector3f up = X_GroundL.linear().row(2).transpose().cast<float>();
  std::vector<PointSet> storeys(seams.size() + 1);
  for (const std::uint32_t i : object.points) {
    const double height_m = (X_GroundL * all.points[i].cast<double>()).z();
    const bool is_top = IsLevel(all.normals[i], up);
    const double above_m = is_top ? kDistanceGate_sigma * double{all.sigma_m[i]} : 0;
    const auto seam = std::ranges::lower_bound(seams, height_m - above_m);
    storeys[static_cast<std::size_t>(seam - seams.begin())].push_back(i);
  }
  return storeys;
}

std::optional<Proposal> SplitOf(const SceneState& state, const ObjectHypothesis& object) {
  const Pose X_GroundL = X_LGround(state.measured(), object.resting)->inverse(Eigen::Isometry);
  const std::optional<Vector2> axis = AxisOf(*object.model, X_GroundL);
  if (!axis) return std::nullopt;
  const std::vector<ProfilePoint> profile = ProfileOf(state, object, X_GroundL, *axis);
  if (profile.empty()) return std::nullopt;
  const std::vector<double> seams = StoreySeams(profile);
  if (seams.empty()) return std::nullopt;
  std::vector<PointSet> storeys = StoreysOf(state, object, X_GroundL, seams);
  if (std::ranges::any_of(storeys, [](const PointSet& one) { return one.empty(); })) {
    return std::nullopt;
  }
  Proposal proposal{.consumes = {{object.id, storeys.size() - 1}}};
  for (std::size_t k = 0; k < storeys.size(); ++k) {
    Product storey{.points = std::move(storeys[k]),
                   .resting = object.resting,
                   .expects = Expectation::kSingleObject};
    storey.node_count = NodesOf(object, storey.points.size());
    if (k > 0) {
      storey.on_product = k - 1;
      storey.resting.foot_height_m = object.resting.foot_height_m + seams[k - 1];
    }
    proposal.products.push_back(std::move(storey));
  }
  return proposal;
}

class SplitStackedRounds : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.stacked_rounds"; }
  std::span<const std::string_view> After() const override;
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The product must be one shape of nearly all points that is no box.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

std::span<const std::string_view> SplitStackedRounds::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"merge.occluded_parts"};
  return kAfter;
}

TrialBudget SplitStackedRounds::MaxWork() const {
  return {.note = "it may be a stack of round objects: the cap of stacks was reached"};
}

std::vector<Proposal> SplitStackedRounds::Propose(const SceneState& state,
                                                  const RefinementContext& context) const {
  std::vector<Proposal> proposals;
  for (const HypothesisPtr& object : state.objects()) {
    context.work.Poll();
    if (object->model->is_given || object->model->shapes().empty()) continue;
    if (auto proposal = SplitOf(state, *object)) proposals.push_back(*std::move(proposal));
  }
  return proposals;
}

bool SplitStackedRounds::Admits(const SceneState&, const Proposal&, std::size_t,
                                const ObjectModel& found) const {
  return IsSingleSolid(found) && !std::holds_alternative<Box>(found.shapes.front().shape);
}

double SplitStackedRounds::Gain(const ModelledProposal& modelled) const {
  return static_cast<double>(modelled.proposal.products.size() - 1);
}

std::unique_ptr<const RefinementPass> MakeSplitStackedRounds() {
  return std::make_unique<const SplitStackedRounds>();
}

}  // namespace cwm::perception
