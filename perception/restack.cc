#include "perception/restack.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/merge_things.h"
#include "perception/order_things.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

// Each models a stack anew; of so many points one may be.
constexpr int kMostAttempts = 6;
constexpr std::size_t kOneModelledAnew = 4;
constexpr std::size_t kMostInGroup = 12;
constexpr float kMostApart_m = 0.01;  // of things that touch: what mixed pixels take from an edge
constexpr double kNearlyAll = 0.96;   // of its points, by one box: the rest are mixed pixels
constexpr float kLevelFace_cos = 0.95f;  // 18 degrees: normals of strips are of their edges too
constexpr float kSide_cos = 0.5f;        // 30 degrees off the upright
// Two faces of one height within noise and warp; flat things are thicker.
constexpr double kSameLevel_sigma = 3;
constexpr double kLeastThickness_m = 0.015;
constexpr std::size_t kFewestLevel = 24;  // two independent ones, of the corner that a turn leaves
constexpr double kFoot = 0.02;            // quantile of heights: below are mixed pixels
// A crease takes from the upper one's foot, or adds to it.
constexpr double kMostCreaseGap_m = 0.01;
constexpr double kOverIt_m = 0.01;  // of the middle of one inside the one below

bool IsBoxOrFace(const ShapePart& part) {
  return !part.vessel &&
         (std::holds_alternative<Box>(part.shape) || std::holds_alternative<Plate>(part.shape));
}

// A layer that took the points of what merely touches it is no better than what was cut.
bool IsOneBox(const ObjectModel& found) {
  return IsOneSolid(found.shapes, found.part_of_point, kNearlyAll) &&
         std::holds_alternative<Box>(found.shapes.front().shape);
}

class Stacker {
 public:
  Stacker(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
          std::vector<ModelledThing>& modelled)
      : options_(options),
        work_(work),
        scene_(scene),
        modelled_(modelled),
        points_left_(scene.points.size() / kOneModelledAnew) {
    options_.modeler.part_touching = false;  // one solid is asked for
  }

  void Run() {
    bool any = false;
    while (attempts_left_ > 0 && StackOne()) any = true;
    if (any) SortBySize(scene_, modelled_);
  }

 private:
  bool StackOne() {
    std::vector<char> tried(CountObjects(scene_), 0);
    bounds_.assign(tried.size(), {});
    for (std::size_t k = 0; k < tried.size(); ++k) bounds_[k] = BoundsOf(modelled_[k]);
    for (std::size_t k = 0; k < tried.size() && attempts_left_ > 0; ++k) {
      work_.Poll();
      if (tried[k] || !IsOfBoxes(k)) continue;
      const std::vector<std::size_t> group = GroupOf(k);
      for (std::size_t other : group) tried[other] = 1;
      if (!IsInOrder(group) && Stack(group)) return true;
    }
    return false;
  }

  // Half of its points and more.
  bool IsOfBoxes(std::size_t k) const {
    const ModelledThing& thing = modelled_[k];
    if (scene_.things[k].supported_by < 0 || thing.thinned_L.empty()) return false;
    const std::vector<ShapePart>& shapes = thing.model->shapes;
    if (std::ranges::any_of(shapes, [](const ShapePart& part) { return part.vessel != nullptr; })) {
      return false;
    }
    const auto of_others = std::ranges::count_if(thing.part_of_point, [&](std::int32_t part) {
      return part >= 0 && part < static_cast<std::int32_t>(shapes.size()) &&
             !IsBoxOrFace(shapes[static_cast<std::size_t>(part)]);
    });
    return 2 * static_cast<std::size_t>(of_others) < thing.part_of_point.size();
  }

  // What touches it, and what touches that.
  std::vector<std::size_t> GroupOf(std::size_t seed) const {
    std::vector<std::size_t> group{seed};
    for (std::size_t at = 0; at < group.size(); ++at) {
      const Eigen::AlignedBox3f bounds = bounds_[group[at]];
      for (std::size_t k = 0; k < CountObjects(scene_) && group.size() < kMostInGroup; ++k) {
        if (std::ranges::count(group, k) > 0 || !IsOfBoxes(k) ||
            scene_.things[k].supported_by != scene_.things[seed].supported_by ||
            bounds.exteriorDistance(bounds_[k]) > kMostApart_m) {
          continue;
        }
        group.push_back(k);
      }
    }
    std::ranges::sort(group);
    return group;
  }

  Pose X_SupportL(std::size_t k) const {
    const auto support = static_cast<std::size_t>(scene_.things[k].supported_by);
    return scene_.supports[support].plate.X_FS.inverse(Eigen::Isometry);
  }

  double HeightQuantile_m(std::size_t k, double share) const {
    const Pose X_SL = X_SupportL(k);
    std::vector<double> heights_m;
    for (const Eigen::Vector3f& p : modelled_[k].thinned_L) {
      heights_m.push_back((X_SL * p.cast<double>()).z());
    }
    return Quantile(std::move(heights_m), share);
  }

  // Each is one box and all of what it shows, none begins in the air but what rests on another, and none
  // on two.
  bool IsInOrder(const std::vector<std::size_t>& group) const {
    return std::ranges::all_of(group, [&](std::size_t k) {
      const ModelledThing& thing = modelled_[k];
      if (!IsOneSolid(thing.model->shapes, thing.part_of_point, kNearlyAll)) return false;
      if (!thing.model->handles.empty()) return false;
      const std::ptrdiff_t below = CountBelow(k, group);
      if (scene_.things[k].rests_on >= 0) return below < 2;
      return below == 0 && FootOfShape_m(k) < kLeastThickness_m && !RunsThrough(k, group);
    });
  }

  double FootOfShape_m(std::size_t k) const {
    const ModelledThing& thing = modelled_[k];
    const ShapePart& part = thing.model->shapes.front();
    return TightBounds(part.shape, X_SupportL(k) * thing.X_LO * part.X_OS).min().z();
  }

  // Of those that end where it begins.
  std::ptrdiff_t CountBelow(std::size_t k, const std::vector<std::size_t>& group) const {
    const double foot_m = HeightQuantile_m(k, kFoot);
    if (foot_m < kLeastThickness_m) return 0;
    return std::ranges::count_if(group, [&](std::size_t other) {
      return other != k &&
             std::abs(HeightQuantile_m(other, 1 - kFoot) - foot_m) <= kMostCreaseGap_m;
    });
  }

  // Whether the middle of another one's solid is deep in its own.
  bool RunsThrough(std::size_t k, const std::vector<std::size_t>& group) const {
    const ModelledThing& thing = modelled_[k];
    const ShapePart& part = thing.model->shapes.front();
    return std::ranges::any_of(group, [&](std::size_t other) {
      if (other == k) return false;
      return std::ranges::any_of(modelled_[other].model->shapes, [&](const ShapePart& of_other) {
        const Vector3 middle = (modelled_[other].X_LO * of_other.X_OS).translation();
        return SignedDistance_m(part, (thing.X_LO * part.X_OS).inverse(Eigen::Isometry) * middle) <
               -kOverIt_m;
      });
    });
  }

  // Heights of level faces above the support, ascending.
  std::vector<double> LevelsOf(const Points& points, const Pose& X_SL) const {
    const Eigen::Vector3f up = X_SL.linear().row(2).transpose().cast<float>();
    std::vector<double> heights_m;
    double sigma_m = 0;
    for (std::uint32_t i : points) {
      sigma_m = std::max(sigma_m, double{scene_.points.sigma_m[i]});
      if (scene_.points.normals[i].dot(up) < kLevelFace_cos) continue;
      heights_m.push_back((X_SL * scene_.points.points[i].cast<double>()).z());
    }
    std::ranges::sort(heights_m);
    const double gate_m = kSameLevel_sigma * sigma_m;
    std::vector<double> levels;
    while (true) {
      std::size_t most = 0, at = 0;
      for (std::size_t first = 0, end = 0; first < heights_m.size(); ++first) {
        while (end < heights_m.size() && heights_m[end] <= heights_m[first] + gate_m) ++end;
        if (end - first > most) most = end - first, at = first;
      }
      if (most < kFewestLevel) break;
      const double level_m = heights_m[at + most / 2];
      std::erase_if(heights_m, [&](double height_m) {
        return std::abs(height_m - level_m) < std::max(kLeastThickness_m, gate_m);
      });
      if (level_m > kLeastThickness_m) levels.push_back(level_m);
    }
    std::ranges::sort(levels);
    return levels;
  }

  // The points up to each level, and above the one before.
  std::vector<Points> LayersOf(const Points& points, const std::vector<double>& levels,
                               const Pose& X_SL) const {
    std::vector<Points> layers(levels.size());
    const Eigen::Vector3f up = X_SL.linear().row(2).transpose().cast<float>();
    for (std::uint32_t i : points) {
      const double height_m = (X_SL * scene_.points.points[i].cast<double>()).z();
      // Where a face meets the side above it, or its own, normals are of both.
      const bool is_side = scene_.points.normals[i].dot(up) < kSide_cos;
      const double above_m = is_side ? 0 : kSameLevel_sigma * double{scene_.points.sigma_m[i]};
      const auto level = std::ranges::lower_bound(levels, height_m - above_m);
      layers[std::min(static_cast<std::size_t>(level - levels.begin()), levels.size() - 1)]
          .push_back(i);
    }
    return layers;
  }

  bool Stack(const std::vector<std::size_t>& group) {
    Points all;
    std::size_t nodes = 0;
    for (std::size_t k : group) {
      all.insert(all.end(), scene_.things[k].points.begin(), scene_.things[k].points.end());
      nodes += scene_.things[k].node_count;
    }
    std::ranges::sort(all);
    if (all.size() > points_left_) return false;
    const Pose X_SL = X_SupportL(group.front());
    const std::vector<double> levels = LevelsOf(all, X_SL);
    if (levels.size() < 2) return false;
    std::vector<Points> layers = LayersOf(all, levels, X_SL);
    if (std::ranges::any_of(layers,
                            [](const Points& layer) { return layer.size() < kFewestLevel; })) {
      return false;
    }
    points_left_ -= all.size();
    --attempts_left_;
    const SegmentedThing pattern = scene_.things[group.front()];
    std::vector<Points> before;
    for (std::size_t k : group) before.push_back(std::exchange(scene_.things[k].points, {}));
    const std::size_t first = CountObjects(scene_);
    for (std::size_t layer = 0; layer < layers.size(); ++layer) {
      SegmentedThing thing;
      thing.supported_by = pattern.supported_by;
      thing.node_count = nodes * layers[layer].size() / all.size();
      thing.points = std::move(layers[layer]);
      if (layer > 0) {
        thing.rests_on = static_cast<std::int32_t>(first + layer - 1);
        thing.foot_height_m = levels[layer - 1];
      }
      scene_.things.insert(scene_.things.begin() + static_cast<std::ptrdiff_t>(first + layer),
                           std::move(thing));
    }
    std::vector<ModelledThing> anew = ModelLayers(first, levels.size(), X_SL);
    if (anew.empty()) {
      const auto at = scene_.things.begin() + static_cast<std::ptrdiff_t>(first);
      scene_.things.erase(at, at + static_cast<std::ptrdiff_t>(levels.size()));
      for (std::size_t k = 0; k < group.size(); ++k) {
        scene_.things[group[k]].points = std::move(before[k]);
      }
      return false;
    }
    modelled_.insert(modelled_.begin() + static_cast<std::ptrdiff_t>(first),
                     std::make_move_iterator(anew.begin()), std::make_move_iterator(anew.end()));
    std::size_t top = first + levels.size() - 1;
    for (std::size_t k = group.size(); k-- > 0; --top) {
      RemoveThing(group[k], top, scene_, modelled_);
    }
    return true;
  }

  // So many things from the first, side by side; nothing where they are no stack of boxes.
  std::vector<ModelledThing> ModelLayers(std::size_t first, std::size_t count,
                                         const Pose& X_SL) const {
    const SceneRays rays(scene_, work_);
    std::vector<std::optional<ModelledThing>> models(count);
    std::atomic<bool> any_fails = false;
    ParallelFor(count, 1, work_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end && !any_fails; ++k) {
        models[k] = ModelThingIf(IsOneBox, scene_, first + k, rays, options_, work_);
        if (!models[k]) any_fails = true;
      }
    });
    std::vector<ModelledThing> layers;
    for (std::optional<ModelledThing>& model : models) {
      if (!model || (!layers.empty() && !LiesOver(*model, layers.back(), X_SL))) return {};
      layers.push_back(*std::move(model));
    }
    return layers;
  }

  // The middle of one over the other.
  bool LiesOver(const ModelledThing& upper, const ModelledThing& lower, const Pose& X_SL) const {
    const Aabb above = BoundsOnSupport(upper, X_SL), below = BoundsOnSupport(lower, X_SL);
    const auto holds = [](const Aabb& bounds, const Vector3& p) {
      return ((p - bounds.min()).head<2>().array() > kOverIt_m).all() &&
             ((bounds.max() - p).head<2>().array() > kOverIt_m).all();
    };
    return holds(below, above.center()) || holds(above, below.center());
  }
  static Aabb BoundsOnSupport(const ModelledThing& thing, const Pose& X_SL) {
    Aabb bounds;
    for (const ShapePart& part : thing.model->shapes) {
      bounds.extend(TightBounds(part.shape, X_SL * thing.X_LO * part.X_OS));
    }
    return bounds;
  }

  InterpretOptions options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  int attempts_left_ = kMostAttempts;
  std::size_t points_left_;
};

}  // namespace

void Restack(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
             std::vector<ModelledThing>& modelled) {
  Stacker(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
