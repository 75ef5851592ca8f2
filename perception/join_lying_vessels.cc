#include "perception/join_lying_vessels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "perception/merge_things.h"
#include "perception/model/model_points.h"
#include "perception/model/object_modeler.h"
#include "perception/order_things.h"
#include "perception/thing_sample.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

constexpr float kLargestVessel_m = 0.75f;  // diagonal of a large pan's bounds with its handle
constexpr float kTouching_m = 0.03f;       // a wall, its rim's shadow, and noise on either side
constexpr double kUpright_cos = 0.97;      // 14 degrees: stands
constexpr double kLeastExplained = 0.9;    // of a thing's points, as of any one solid
constexpr double kLeastOnShell = 0.8;      // of the points of a part; the rest: noise at its edge
constexpr std::size_t kMostParts = 8;      // of the largest that touch
// Each looks at a few things anew, and may model them. Of 45 real scans one asked for more than is
// allowed, of clutter.
constexpr int kMostAttempts = 6;
constexpr std::size_t kOneModelledAnew = 8;  // of the scene's points, as of joined things

class LyingVesselJoiner {
 public:
  LyingVesselJoiner(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                    std::vector<ModelledThing>& modelled)
      : options_(options),
        work_(work),
        scene_(scene),
        modelled_(modelled),
        points_left_(scene.points.size() / kOneModelledAnew) {}

  void Run() {
    for (const ModelledThing& thing : modelled_) bounds_.push_back(BoundsOf(thing));
    bool any = false;
    for (std::size_t a = 0; a < modelled_.size();) {
      work_.Poll();
      if (MayBeOfLyingVessel(a) && Join(a)) {
        any = true;  // others have taken its place, or it reaches others now
      } else {
        ++a;
      }
    }
    if (any) SortBySize(scene_, modelled_);
  }

 private:
  // What is one closed solid is none, nor what is flat, nor what became a vessel that stands although it
  // might have become one that lies.
  bool MayBeOfLyingVessel(std::size_t a) const {
    const ModelledThing& thing = modelled_[a];
    if (scene_.things[a].supported_by < 0 || !IsSmall(a) || IsFlat(thing)) return false;
    const auto stands = [&](const ShapePart& part) {
      return part.vessel && (thing.X_LO * part.X_OS).linear()(2, 2) >= kUpright_cos;
    };
    if (std::ranges::any_of(thing.model->shapes, stands)) return false;
    return !IsOneSolid(thing.model->shapes, thing.part_of_point, kLeastExplained) ||
           thing.model->shapes.front().vessel;
  }

  static bool IsFlat(const ModelledThing& thing) {
    const std::vector<ShapePart>& shapes = thing.model->shapes;
    const auto flat = std::ranges::count_if(thing.part_of_point, [&](std::int32_t part) {
      if (part < 0 || static_cast<std::size_t>(part) >= shapes.size()) return false;
      const ShapeKind kind = KindOf(shapes[static_cast<std::size_t>(part)].shape);
      return kind == ShapeKind::kBox || kind == ShapeKind::kPlate;
    });
    return static_cast<double>(flat) >=
           kLeastExplained * static_cast<double>(thing.part_of_point.size());
  }

  bool IsSmall(std::size_t k) const {
    return scene_.things[k].plates.empty() && !bounds_[k].isEmpty() &&
           bounds_[k].diagonal().norm() <= kLargestVessel_m;
  }

  // What lies within reach of one another, the largest of it.
  std::vector<std::size_t> Touching(std::size_t a) const {
    std::vector<std::size_t> touching;
    for (std::size_t b = 0; b < modelled_.size(); ++b) {
      const std::int32_t on = scene_.things[b].supported_by;
      const bool may_touch =
          b != a && IsSmall(b) && (on < 0 || on == scene_.things[a].supported_by);
      if (may_touch && Touch(a, b)) touching.push_back(b);
    }
    std::ranges::stable_sort(touching, std::greater(),
                             [&](std::size_t b) { return scene_.things[b].points.size(); });
    if (touching.size() > kMostParts) touching.resize(kMostParts);
    return touching;
  }

  bool Touch(std::size_t a, std::size_t b) const {
    if (bounds_[a].exteriorDistance(bounds_[b]) > kTouching_m) return false;
    const auto near = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& q) {
      return (p - q).squaredNorm() <= kTouching_m * kTouching_m;
    };
    return std::ranges::any_of(modelled_[a].thinned_L, [&](const Eigen::Vector3f& p) {
      return bounds_[b].exteriorDistance(p) <= kTouching_m &&
             std::ranges::any_of(modelled_[b].thinned_L,
                                 [&](const Eigen::Vector3f& q) { return near(p, q); });
    });
  }

  // Of bounded solids and of plates, whose z may be that of a floor.
  std::vector<Vector3> AxesOf(const std::vector<std::size_t>& parts) const {
    std::vector<Vector3> axes;
    for (std::size_t k : parts) {
      for (const ShapePart& part : modelled_[k].model->shapes) {
        if (KindOf(part.shape) == ShapeKind::kSphere) continue;
        axes.emplace_back((modelled_[k].X_LO * part.X_OS).linear().col(2));
      }
    }
    return axes;
  }

  SegmentedThing Merged(const std::vector<std::size_t>& parts) const {
    SegmentedThing merged = scene_.things[parts.front()];
    for (std::size_t k = 1; k < parts.size(); ++k) {
      SegmentedThing part = scene_.things[parts[k]];
      TakeOver(merged, part);
    }
    return merged;
  }

  double ShareOn(const ShapePart& shell, const Points& points) const {
    const Points some = Thinned(points, kJudgedPoints);
    const Pose X_SL = shell.X_OS.inverse(Eigen::Isometry);
    const auto on = std::ranges::count_if(some, [&](std::uint32_t i) {
      const Vector3 p = X_SL * scene_.points.points[i].cast<double>();
      return std::abs(SignedDistance_m(shell, p)) <=
             kDistanceGate_sigma * double{scene_.points.sigma_m[i]};
    });
    return static_cast<double>(on) / static_cast<double>(some.size());
  }

  // The thing and those that touch it become one, of those that lie on one shell, if that accounts for
  // them.
  bool Join(std::size_t a) {
    std::vector<std::size_t> parts = Touching(a);
    if (parts.empty()) return false;
    parts.push_back(a);
    std::ranges::sort(parts);  // objects before residuals
    const SegmentedThing merged = Merged(parts);
    if (attempts_ == kMostAttempts || merged.points.size() > points_left_) {
      if (!std::exchange(told_of_cap_, true)) {
        modelled_[a].notes.emplace_back(
            "parts of a vessel that lies may stand apart: the cap of joins was reached");
      }
      return false;
    }
    points_left_ -= merged.points.size();
    ++attempts_;
    const std::optional<ShapePart> shell =
        FindLyingVessel(ThingSample(scene_, merged).Points(), WhatItStandsOn(scene_, merged),
                        AxesOf(parts), options_.noise, options_.modeler, work_);
    if (!shell) return false;
    std::erase_if(parts, [&](std::size_t k) {
      return ShareOn(*shell, scene_.things[k].points) < kLeastOnShell;
    });
    return parts.size() > 1 && ModelAsOne(parts);
  }

  bool ModelAsOne(const std::vector<std::size_t>& parts) {
    const std::size_t first = parts.front();
    std::vector<SegmentedThing> before;
    for (std::size_t k : parts) before.push_back(scene_.things[k]);
    for (std::size_t k = 1; k < parts.size(); ++k) {
      TakeOver(scene_.things[first], scene_.things[parts[k]]);
    }
    const auto is_vessel = [](const ObjectModel& found) {
      const auto left = std::ranges::count(found.part_of_point, kUnexplained);
      return found.shapes.size() == 1 && found.shapes.front().vessel &&
             static_cast<double>(left) <=
                 (1 - kLeastExplained) * static_cast<double>(found.part_of_point.size());
    };
    std::optional<ModelledThing> whole =
        ModelThingIf(is_vessel, scene_, first, SceneRays(scene_, work_), options_, work_);
    bool is_one = whole.has_value();
    for (std::size_t k = 0; k < parts.size() && is_one; ++k) {
      is_one = AccountsFor(*whole, modelled_[parts[k]], before[k].points, scene_.points);
    }
    if (!is_one) {
      for (std::size_t k = 0; k < parts.size(); ++k) scene_.things[parts[k]] = std::move(before[k]);
      return false;
    }
    modelled_[first] = *std::move(whole);
    bounds_[first] = BoundsOf(modelled_[first]);
    for (std::size_t k = parts.size(); k-- > 1;) {
      bounds_.erase(bounds_.begin() + static_cast<std::ptrdiff_t>(parts[k]));
      RemoveThing(parts[k], first, scene_, modelled_);
    }
    return true;
  }

  const InterpretOptions& options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  int attempts_ = 0;
  std::size_t points_left_;
  bool told_of_cap_ = false;
};

}  // namespace

void JoinLyingVessels(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                      std::vector<ModelledThing>& modelled) {
  if (SearchesAny(options.modeler)) LyingVesselJoiner(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
