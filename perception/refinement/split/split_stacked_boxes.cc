#include "perception/refinement/split/split_stacked_boxes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/refinement/evidence.h"
#include "perception/search/model_points.h"

namespace cwm::perception {
namespace {

// True if one solid explains all points but the mixed pixels at its edges. With a touching object
// it would explain fewer, so nearly all is not enough.
bool IsPureSolid(const ObjectModel& model) { return IsSingleSolid(model, 1 - kMaxPassing); }

bool IsBoxOrFace(const ShapePart& part) {
  return !part.vessel &&
         (std::holds_alternative<Box>(part.shape) || std::holds_alternative<Plate>(part.shape));
}

using Group = std::vector<const ObjectHypothesis*>;

// True if fewer than half of the points belong to shapes other than boxes and faces; unexplained
// points count as those of boxes. False with a vessel, or if a pass supplied the shapes.
bool IsOfBoxes(const ObjectHypothesis& object) {
  const HypothesisModel& model = *object.model;
  if (model.is_given || model.thinned_L.empty()) return false;
  const std::vector<ShapePart>& shapes = model.shapes();
  if (std::ranges::any_of(shapes, [](const ShapePart& part) { return part.vessel != nullptr; })) {
    return false;
  }
  const auto of_others = std::ranges::count_if(model.part_of_point(), [&](std::int32_t part) {
    return part >= 0 && part < static_cast<std::int32_t>(shapes.size()) &&
           !IsBoxOrFace(shapes[static_cast<std::size_t>(part)]);
  });
  return 2 * static_cast<std::size_t>(of_others) < model.part_of_point().size();
}

class Stacker {
 public:
  explicit Stacker(const SceneState& state) : state_(state) {}

  std::vector<Proposal> Run(const Work& work) const {
    std::vector<Proposal> proposals;
    std::set<const ObjectHypothesis*> seen;
    for (const HypothesisPtr& object : state_.objects()) {
      work.Poll();
      if (seen.contains(object.get()) || !IsOfBoxes(*object)) continue;
      const Group group = GroupOf(*object);
      seen.insert(group.begin(), group.end());
      if (IsInOrder(group)) continue;
      if (auto proposal = StackOf(group)) proposals.push_back(*std::move(proposal));
    }
    return proposals;
  }

 private:
  // The seed and all objects that touch it, directly or by way of others.
  Group GroupOf(const ObjectHypothesis& seed) const {
    Group group{&seed};
    for (std::size_t at = 0; at < group.size(); ++at) {
      const Eigen::AlignedBox3f bounds = group[at]->model->bounds_L;
      for (const HypothesisPtr& other : state_.objects()) {
        if (group.size() == kMaxGroupSize) break;
        if (std::ranges::count(group, other.get()) > 0 || !IsOfBoxes(*other) ||
            other->resting.support != seed.resting.support ||
            bounds.exteriorDistance(other->model->bounds_L) > kMaxContactGap_m) {
          continue;
        }
        group.push_back(other.get());
      }
    }
    std::ranges::sort(group, {},
                      [&](const ObjectHypothesis* one) { return state_.IndexOf(one->id); });
    return group;
  }

  Pose X_SupportL(const ObjectHypothesis& object) const {
    return X_LGround(state_.measured(), {.support = object.resting.support})
        ->inverse(Eigen::Isometry);
  }

  double HeightQuantile_m(const ObjectHypothesis& object, double share) const {
    const Pose X_SL = X_SupportL(object);
    std::vector<double> heights_m;
    for (const Eigen::Vector3f& p : object.model->thinned_L) {
      heights_m.push_back((X_SL * p.cast<double>()).z());
    }
    return Quantile(std::move(heights_m), share);
  }

  // True if each object is one box that explains all its points, and rests on the support or on one
  // other object only.
  bool IsInOrder(const Group& group) const {
    return std::ranges::all_of(group, [&](const ObjectHypothesis* object) {
      const HypothesisModel& model = *object->model;
      if (!IsPureSolid(model.object)) return false;
      if (!model.handles().empty()) return false;
      const std::ptrdiff_t below = CountBelow(*object, group);
      if (object->resting.on) return below < 2;
      return below == 0 && FootOfShape_m(*object) < kMaxSameFaceGap_m &&
             !RunsThrough(*object, group);
    });
  }

  double FootOfShape_m(const ObjectHypothesis& object) const {
    const ShapePart& part = object.model->shapes().front();
    return TightBounds(part.shape, X_SupportL(object) * part.X_OS).min().z();
  }

  // The number of objects whose tops are at the height of this one's foot, within the distance that
  // a crease hides or adds; 0 if the foot is on the support.
  std::ptrdiff_t CountBelow(const ObjectHypothesis& object, const Group& group) const {
    const double foot_m = HeightQuantile_m(object, kMixedPixels);
    if (foot_m < kMaxSameFaceGap_m) return 0;
    return std::ranges::count_if(group, [&](const ObjectHypothesis* other) {
      return other != &object &&
             std::abs(HeightQuantile_m(*other, 1 - kMixedPixels) - foot_m) <= kMaxContactGap_m;
    });
  }

  // True if the middle of another object's solid is deep inside this one's.
  bool RunsThrough(const ObjectHypothesis& object, const Group& group) const {
    const ShapePart& part = object.model->shapes().front();
    const Pose X_SL = part.X_OS.inverse(Eigen::Isometry);
    return std::ranges::any_of(group, [&](const ObjectHypothesis* other) {
      if (other == &object) return false;
      return std::ranges::any_of(other->model->shapes(), [&](const ShapePart& of_other) {
        return SignedDistance_m(part, X_SL * of_other.X_OS.translation()) < -kMaxContactGap_m;
      });
    });
  }

  // Heights of level faces above the support, ascending.
  std::vector<double> LevelsOf(const PointSet& points, const Pose& X_SL) const {
    const Eigen::Vector3f up = X_SL.linear().row(2).transpose().cast<float>();
    std::vector<double> heights_m;
    double sigma_m = 0;
    for (std::uint32_t i : points) {
      sigma_m = std::max(sigma_m, double{state_.points().sigma_m[i]});
      if (!IsLevel(state_.points().normals[i], up)) continue;
      heights_m.push_back((X_SL * state_.points().points[i].cast<double>()).z());
    }
    std::ranges::sort(heights_m);
    const double gate_m = kDistanceGate_sigma * sigma_m;
    std::vector<double> levels;
    while (true) {
      std::size_t max_count = 0, at = 0;
      for (std::size_t first = 0, end = 0; first < heights_m.size(); ++first) {
        while (end < heights_m.size() && heights_m[end] <= heights_m[first] + gate_m) ++end;
        if (end - first > max_count) max_count = end - first, at = first;
      }
      if (max_count < kTwoSamples) break;
      const double level_m = heights_m[at + max_count / 2];
      std::erase_if(heights_m, [&](double height_m) {
        return std::abs(height_m - level_m) < std::max(kMaxSameFaceGap_m, gate_m);
      });
      if (level_m > kMaxSameFaceGap_m) levels.push_back(level_m);
    }
    std::ranges::sort(levels);
    return levels;
  }

  // The points between each level and the one before.
  std::vector<PointSet> LayersOf(const PointSet& points, const std::vector<double>& levels,
                                 const Pose& X_SL) const {
    std::vector<PointSet> layers(levels.size());
    const Eigen::Vector3f up = X_SL.linear().row(2).transpose().cast<float>();
    for (std::uint32_t i : points) {
      const double height_m = (X_SL * state_.points().points[i].cast<double>()).z();
      // Points whose normals are not those of a side belong to a level up to their noise above it.
      // At the border between a face and a side, normals are a mixture of both.
      const bool is_side = state_.points().normals[i].dot(up) < kWallRise_sin;
      const double above_m = is_side ? 0 : kDistanceGate_sigma * double{state_.points().sigma_m[i]};
      const auto level = std::ranges::lower_bound(levels, height_m - above_m);
      layers[std::min(static_cast<std::size_t>(level - levels.begin()), levels.size() - 1)]
          .push_back(i);
    }
    return layers;
  }

  std::optional<Proposal> StackOf(const Group& group) const {
    std::vector<HypothesisId> ids;
    for (const ObjectHypothesis* object : group) ids.push_back(object->id);
    const Product all = Merged(state_, ids);
    const Pose X_SL = X_SupportL(*group.front());
    const std::vector<double> levels = LevelsOf(all.points, X_SL);
    if (levels.size() < 2) return std::nullopt;
    std::vector<PointSet> layers = LayersOf(all.points, levels, X_SL);
    if (std::ranges::any_of(layers,
                            [](const PointSet& layer) { return layer.size() < kTwoSamples; })) {
      return std::nullopt;
    }
    Proposal proposal;
    for (const HypothesisId id : ids) proposal.consumes.push_back({id, layers.size() - 1});
    for (std::size_t k = 0; k < layers.size(); ++k) {
      Product layer{.points = std::move(layers[k]),
                    .resting = {.support = group.front()->resting.support},
                    .expects = Expectation::kSingleObject};
      layer.node_count = all.node_count * layer.points.size() / all.points.size();
      if (k > 0) {
        layer.on_product = k - 1;
        layer.resting.foot_height_m = levels[k - 1];
      }
      proposal.products.push_back(std::move(layer));
    }
    return proposal;
  }

  const SceneState& state_;
};

Aabb BoundsOnSupport(const HypothesisModel& model, const Pose& X_SL) {
  Aabb bounds;
  for (const ShapePart& part : model.shapes()) {
    bounds.extend(TightBounds(part.shape, X_SL * part.X_OS));
  }
  return bounds;
}

// True if the middle of one is well over the other.
bool LiesOver(const HypothesisModel& upper, const HypothesisModel& lower, const Pose& X_SL) {
  const Aabb above = BoundsOnSupport(upper, X_SL), below = BoundsOnSupport(lower, X_SL);
  const auto holds = [](const Aabb& bounds, const Vector3& p) {
    return ((p - bounds.min()).head<2>().array() > kMaxContactGap_m).all() &&
           ((bounds.max() - p).head<2>().array() > kMaxContactGap_m).all();
  };
  return holds(below, above.center()) || holds(above, below.center());
}

class SplitStackedBoxes : public RefinementPass {
 public:
  std::string_view Name() const override { return "split.stacked_boxes"; }
  std::span<const std::string_view> After() const override;
  TrialBudget MaxWork() const override;
  std::vector<Proposal> Propose(const SceneState& state,
                                const RefinementContext& context) const override;
  // The product must be one box of nearly all points: a layer with points of a touching object is
  // no better than the replaced one.
  bool Admits(const SceneState& state, const Proposal& proposal, std::size_t product,
              const ObjectModel& found) const override;
  double Gain(const ModelledProposal& modelled) const override;
};

}  // namespace

std::span<const std::string_view> SplitStackedBoxes::After() const {
  static constexpr std::array<std::string_view, 1> kAfter = {"split.standing_solids"};
  return kAfter;
}

TrialBudget SplitStackedBoxes::MaxWork() const {
  return {.note = "it may be a stack of boxes: the cap of stacks was reached"};
}

std::vector<Proposal> SplitStackedBoxes::Propose(const SceneState& state,
                                                 const RefinementContext& context) const {
  return Stacker(state).Run(context.work);
}

bool SplitStackedBoxes::Admits(const SceneState&, const Proposal&, std::size_t,
                               const ObjectModel& found) const {
  return IsPureSolid(found) && std::holds_alternative<Box>(found.shapes.front().shape);
}

double SplitStackedBoxes::Gain(const ModelledProposal& modelled) const {
  const Pose X_SL = X_LGround(modelled.state.measured(),
                              {.support = modelled.proposal.products.front().resting.support})
                        ->inverse(Eigen::Isometry);
  for (std::size_t k = 1; k < modelled.products.size(); ++k) {
    if (!LiesOver(*modelled.products[k], *modelled.products[k - 1], X_SL)) return 0;
  }
  return 1;
}

std::unique_ptr<const RefinementPass> MakeSplitStackedBoxes() {
  return std::make_unique<const SplitStackedBoxes>();
}

}  // namespace cwm::perception
