#include "perception/refinement/split/split_unexplained_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/seen_width.h"
#include "perception/cloud/tolerances.h"
#include "perception/refinement/criterion.h"
#include "perception/refinement/evidence.h"
#include "perception/search/connectivity.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

constexpr double kMinSamples = 8;  // chosen: independent samples of a part; fewer show no sizes

// Indices of a proposal's products.
enum : std::size_t { kPart, kRest };

// Heights and horizontal places over the object's ground.
class OverGround {
 public:
  OverGround(const SceneState& state, const ObjectHypothesis& object)
      : points_(state.points()),
        X_GroundL_(X_LGround(state.measured(), object.resting)->inverse(Eigen::Isometry)) {}

  double Height_m(const PointSet& members, double share) const {
    std::vector<double> heights_m;
    for (const std::uint32_t i : members) heights_m.push_back(At(i).z());
    return Quantile(std::move(heights_m), share);
  }
  // True if the points rise above what noise and warp lift off the support.
  bool Rises(const PointSet& members) const {
    double max_m = 0;
    for (const std::uint32_t i : members) {
      max_m = std::max(max_m, double{points_.WidePlaneTolerance_m(i)});
    }
    return Height_m(members, 1 - kMixedPixels) > max_m;
  }
  // True if, seen from above, the middle of the points lies within the bounds of the others.
  bool IsOver(const PointSet& members, const PointSet& others) const {
    Eigen::AlignedBox2d bounds;
    for (const std::uint32_t i : others) bounds.extend(Vector2(At(i).head<2>()));
    Vector2 middle = Vector2::Zero();
    for (const std::uint32_t i : members) middle += At(i).head<2>();
    return bounds.contains(middle / static_cast<double>(members.size()));
  }

 private:
  Vector3 At(std::uint32_t i) const { return X_GroundL_ * points_.points[i].cast<double>(); }

  const OrientedPoints& points_;
  Pose X_GroundL_;
};

// The largest connected part of the points that no closed solid explains. Ascending.
PointSet LargestUnexplained(const OrientedPoints& all, const ObjectHypothesis& object) {
  const std::vector<ShapePart>& shapes = object.model->shapes();
  PointSet off;
  for (std::size_t k = 0; k < object.points.size(); ++k) {
    const auto part = static_cast<std::size_t>(object.model->part_of_point()[k]);
    if (part >= shapes.size() || !IsClosed(shapes[part])) off.push_back(object.points[k]);
  }
  if (off.empty()) return off;
  std::vector<Eigen::Vector3f> places;
  double sigma_m = 0;
  for (const std::uint32_t i : off) {
    places.push_back(all.points[i]);
    sigma_m = std::max(sigma_m, double{all.sigma_m[i]});
  }
  const double pitch_m = SeenPitch_m(places, all.viewpoint);
  const double cell_m =
      std::max({kSpacingsPerCell * pitch_m, kDistanceGate_sigma * sigma_m, double{kUnevenness_m}});
  std::vector<std::uint32_t> indices(off.size());
  std::iota(indices.begin(), indices.end(), 0U);
  const Connectivity connectivity(places, static_cast<float>(cell_m));
  PointSet largest;
  for (const std::uint32_t k : connectivity.LargestComponent(indices)) largest.push_back(off[k]);
  std::ranges::sort(largest);
  return largest;
}

Proposal SplitOff(const SceneState& state, const ObjectHypothesis& object, PointSet members) {
  const OverGround over(state, object);
  Product rest = Without(object, members);
  Product part{.node_count = NodesOf(object, members.size()),
               .resting = object.resting,
               .expects = Expectation::kSingleObject};
  part.points = std::move(members);
  const bool is_in_plan = over.IsOver(part.points, rest.points);
  const double part_top_m = over.Height_m(part.points, 1 - kMixedPixels);
  const double part_foot_m = over.Height_m(part.points, kMixedPixels);
  if (is_in_plan && part_top_m < over.Height_m(rest.points, 0.5)) {
    rest.on_product = kPart;
    // The upper object hides the wall of the lower one where it overhangs, whose top may seem too
    // low.
    rest.resting.foot_height_m += std::max(part_top_m, over.Height_m(rest.points, kMixedPixels));
  } else if (is_in_plan && part_foot_m > over.Height_m(rest.points, 0.5)) {
    part.on_product = kRest;
    part.resting.foot_height_m += part_foot_m;
  }
  return {.consumes = {{object.id, kRest}}, .products = {std::move(part), std::move(rest)}};
}

class SplitUnexplainedParts : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.unexplained_parts"; }
  std::span<const std::string_view> After() const override {
    static constexpr std::array<std::string_view, 2> kAfter = {"reassign.points",
                                                               "split.standing_solids"};
    return kAfter;
  }
  TrialBudget MaxWork() const override {
    // Most parts are examined without a gain, so half of all points are allowed.
    return {.max_trials = kMaxTrials,
            .points_divisor = 2,
            .note = "parts of it may be objects of their own: the cap of parts was reached"};
  }

  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override {
    const OrientedPoints& all = state.points();
    std::vector<Proposal> proposals;
    for (const HypothesisPtr& object : state.objects()) {
      context.work.Poll();
      const std::vector<ShapePart>& shapes = object->model->shapes();
      const bool has_vessel = std::ranges::any_of(
          shapes, [](const ShapePart& shape) { return shape.vessel != nullptr; });
      if (object->model->is_given || has_vessel || std::ranges::none_of(shapes, IsClosed)) continue;
      PointSet members = LargestUnexplained(all, *object);
      if (static_cast<double>(members.size()) < kMinSamples * double{all.points_per_sample} ||
          members.size() == object->points.size() || !OverGround(state, *object).Rises(members)) {
        continue;
      }
      proposals.push_back(SplitOff(state, *object, std::move(members)));
    }
    return proposals;
  }

  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override {
    if (product == kRest) return !found.shapes.empty();
    if (!IsSingleSolid(found) || !IsClosed(found.shapes.front())) return false;
    const Pose X_GroundL =
        X_LGround(state.measured(), proposal.products[kPart].resting)->inverse(Eigen::Isometry);
    const ShapePart& solid = found.shapes.front();
    // A round part on top of an object is its neck, lid or knob.
    if (proposal.products[kPart].on_product && !std::holds_alternative<Box>(solid.shape))
      return false;
    return std::abs(TightBounds(solid.shape, X_GroundL * solid.X_OS).min().z()) <= kMaxContactGap_m;
  }

  double Gain(const ModelledProposal& modelled) const override { return CriterionGain(modelled); }
};

}  // namespace

std::unique_ptr<const RefinementPass> MakeSplitUnexplainedParts() {
  return std::make_unique<const SplitUnexplainedParts>();
}

}  // namespace cwm::perception
