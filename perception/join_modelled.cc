#include "perception/join_modelled.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "collision/geometry/hybrid_model.h"
#include "perception/merge_things.h"
#include "perception/model/explain.h"
#include "perception/model/model_points.h"
#include "perception/model/prolonged.h"
#include "perception/order_things.h"
#include "perception/scene/surface_graph.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

// As of parts that share a plane (join_hidden).
constexpr double kLargestGap_m = 0.35;
constexpr std::size_t kSightLines = 48;
constexpr int kPlacesPerLine = 8;
constexpr double kMostContradictions = 0.06;
constexpr double kLeastHidden = 0.25;

// Each models two things anew. Of 317 scenes, real and simulated, none asked for more than three.
constexpr int kMostAttempts = 6;
constexpr int kMostReturns = 6;  // of handles, likewise
// Of so many points one may be modelled anew: six joins of two things of 1 % of the scene each do not
// use that up, and what fills the view with noise is not modelled twice.
constexpr std::size_t kOneModelledAnew = 8;
constexpr std::size_t kSample = 64;       // points, to ask whether a solid reaches so far
constexpr double kLeastProlonging = 0.6;  // of them, on the prolonged surface
constexpr double kLeastExplained = 0.9;   // of their points, as of any one solid
constexpr double kLeastAlone = 0.8;  // likewise of what is prolonged; true parts had that and more
constexpr double kThickestLid_m = 0.01;  // lone faces have 5 mm and what the noise adds

class Joiner {
 public:
  Joiner(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
         std::vector<ModelledThing>& modelled)
      : options_(options),
        work_(work),
        scene_(scene),
        modelled_(modelled),
        points_left_(scene.points.size() / kOneModelledAnew) {}

  void Run() {
    for (const ModelledThing& thing : modelled_) bounds_.push_back(BoundsOf(thing));
    ReturnHandles();
    JoinAll();
    if (any_joined_) SortBySize(scene_, modelled_);
  }

 private:
  void JoinAll() {
    for (std::size_t a = 0; a < modelled_.size(); ++a) {
      for (std::size_t b = a + 1; b < modelled_.size();) {
        work_.Poll();
        if (!MayBeOne(a, b)) {
          ++b;
          continue;
        }
        if (!MaySpend(a, b)) {
          if (!std::exchange(told_of_points_, true)) {
            modelled_[a].notes.push_back(
                "parts of it may stand apart: the cap of points of joins was reached");
          }
          ++b;
          continue;
        }
        if (attempts_ == kMostAttempts) {
          modelled_[a].notes.push_back("parts of it may stand apart: the cap of joins was reached");
          return;
        }
        ++attempts_;
        if (Join(a, b)) {
          any_joined_ = true;
          b = a + 1;  // what it has become may reach others
        } else {
          ++b;
        }
      }
    }
  }

  // What an occluder cuts off may stand out from another thing, as a handle does.
  void ReturnHandles() {
    for (std::size_t a = 0; a < modelled_.size(); ++a) {
      for (std::size_t b = 0; b < modelled_.size() && returns_ < kMostReturns; ++b) {
        if (modelled_[a].model->handles.empty()) break;
        if (a == b || !MayOwn(b, a)) continue;
        work_.Poll();
        const Points handles = HandlesOn(a, b);
        if (handles.empty() || !MaySpend(a, b)) continue;
        ++returns_;
        any_joined_ |= Return(handles, a, b);
      }
    }
  }

  // What stands on something, and beside it what stands there too or hangs in the air.
  bool MayOwn(std::size_t owner, std::size_t taker) const {
    const std::int32_t on = scene_.things[owner].supported_by;
    const std::int32_t other_on = scene_.things[taker].supported_by;
    return on >= 0 && (other_on < 0 || other_on == on) &&
           bounds_[owner].exteriorDistance(bounds_[taker]) <= kLargestGap_m;
  }

  // To model both anew.
  bool MaySpend(std::size_t a, std::size_t b) {
    const std::size_t points = scene_.things[a].points.size() + scene_.things[b].points.size();
    if (points > points_left_) return false;
    points_left_ -= points;
    return true;
  }

  // The points of those handles of a thing that lie on the one solid that another is, as it is or
  // prolonged.
  Points HandlesOn(std::size_t a, std::size_t b) const {
    const ModelledThing &thing = modelled_[a], &other = modelled_[b];
    Points found;
    if (!IsOneSolid(other.model->shapes, other.part_of_point, kLeastAlone)) return found;
    const ShapePart& solid = other.model->shapes.front();
    if (solid.vessel) return found;
    const Pose X_SL = (other.X_LO * solid.X_OS).inverse(Eigen::Isometry);
    for (std::size_t h = 0; h < thing.model->handles.size(); ++h) {
      const auto part = static_cast<std::int32_t>(thing.model->shapes.size() + h);
      Points members;
      std::size_t on = 0;
      for (std::size_t k = 0; k < thing.part_of_point.size(); ++k) {
        if (thing.part_of_point[k] != part) continue;
        const std::uint32_t i = scene_.things[a].points[k];
        members.push_back(i);
        on += IsOnSolid(solid, X_SL, i) || IsOnProlonged(solid, X_SL, i);
      }
      if (static_cast<double>(on) < kLeastAlone * static_cast<double>(members.size())) continue;
      found.insert(found.end(), members.begin(), members.end());
    }
    std::ranges::sort(found);
    return found;
  }

  // Models both anew, with and without what the first had for handles.
  bool Return(const Points& handles, std::size_t a, std::size_t b) {
    SegmentedThing &taker = scene_.things[a], &owner = scene_.things[b];
    if (handles.size() == taker.points.size()) return false;
    if (Between(handles, owner.points).through > kMostContradictions) return false;
    const SegmentedThing before_a = taker, before_b = owner;
    GivePoints(handles, taker, owner);
    const SceneRays rays(scene_, work_);
    const auto is_one_solid = [](const ObjectModel& found) {
      return IsOneSolid(found.shapes, found.part_of_point, kLeastExplained);
    };
    std::optional<ModelledThing> whole =
        ModelThingIf(is_one_solid, scene_, b, rays, options_, work_);
    if (!whole || !Explains(*whole, owner.points, handles)) {
      taker = before_a;
      owner = before_b;
      return false;
    }
    modelled_[a] = ModelThing(scene_, a, rays, options_, work_);
    modelled_[b] = *std::move(whole);
    bounds_[a] = BoundsOf(modelled_[a]);
    bounds_[b] = BoundsOf(modelled_[b]);
    return true;
  }

  // Whether the thing's first shape accounts for these of its points, which are ascending.
  static bool Explains(const ModelledThing& thing, const Points& all, const Points& some) {
    std::size_t explained = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
      explained += thing.part_of_point[k] == 0 && std::ranges::binary_search(some, all[k]);
    }
    return static_cast<double>(explained) >= kLeastAlone * static_cast<double>(some.size());
  }

  bool MayBeOne(std::size_t a, std::size_t b) const {
    const SegmentedThing &first = scene_.things[a], &second = scene_.things[b];
    if (first.supported_by < 0 || first.supported_by != second.supported_by) return false;
    if (bounds_[a].exteriorDistance(bounds_[b]) > kLargestGap_m) return false;
    return (Prolongs(modelled_[a], second) || Prolongs(modelled_[b], first) || IsLidOn(a, b) ||
            IsLidOn(b, a)) &&
           IsHiddenBetween(first.points, second.points);
  }

  // Whether the thing is a lone face that rests on the other one: of what an occluder leaves of a
  // cup, the lid and a strip of the wall may be things apart, and a cup prolonged is no cylinder.
  bool IsLidOn(std::size_t lid, std::size_t other) const {
    const ModelledThing& thing = modelled_[lid];
    if (scene_.things[lid].rests_on != static_cast<std::int32_t>(other)) return false;
    if (!IsOneSolid(thing.model->shapes, thing.part_of_point, kLeastAlone)) return false;
    const Aabb bounds_S = TightBounds(thing.model->shapes.front().shape, Pose::Identity());
    return bounds_S.sizes().minCoeff() <= kThickestLid_m;
  }

  // Whether the thing is a solid that, prolonged, explains the other one.
  bool Prolongs(const ModelledThing& thing, const SegmentedThing& other) const {
    if (!IsOneSolid(thing.model->shapes, thing.part_of_point, kLeastAlone)) return false;
    const ShapePart& solid = thing.model->shapes.front();
    if (solid.vessel) return false;  // has no end that goes on
    const Points sample = Thinned(other.points, kSample);
    const Pose X_SL = (thing.X_LO * solid.X_OS).inverse(Eigen::Isometry);
    const auto on = std::ranges::count_if(
        sample, [&](std::uint32_t i) { return IsOnProlonged(solid, X_SL, i); });
    return static_cast<double>(on) >= kLeastProlonging * static_cast<double>(sample.size());
  }

  bool IsOnSolid(const ShapePart& solid, const Pose& X_SL, std::uint32_t point) const {
    const Vector3 p = X_SL * scene_.points.points[point].cast<double>();
    return std::abs(SignedDistance_m(solid, p)) <=
           kDistanceGate_sigma * double{scene_.points.sigma_m[point]};
  }
  bool IsOnProlonged(const ShapePart& solid, const Pose& X_SL, std::uint32_t point) const {
    const Vector3 p = X_SL * scene_.points.points[point].cast<double>();
    return ProlongedDistance_m(solid.shape, p) <=
           std::max(kBelongs_m, kDistanceGate_sigma * double{scene_.points.sigma_m[point]});
  }

  // Of places on straight lines between them, the shares that were seen through and that are hidden.
  struct Sight {
    double through = 0, hidden = 0;
  };
  Sight Between(const Points& a, const Points& b) const {
    int through = 0, hidden = 0, seen = 0;
    for (std::size_t line = 0; line < kSightLines; ++line) {
      // Evenly spread over both, in an order that pairs each with many of the other.
      const std::uint32_t i = a[line * a.size() / kSightLines];
      const std::uint32_t j = b[line * 19 % kSightLines * b.size() / kSightLines];
      for (int k = 1; k < kPlacesPerLine; ++k) {
        const float t = static_cast<float>(k) / kPlacesPerLine;
        const Eigen::Vector3f place =
            (1 - t) * scene_.points.points[i] + t * scene_.points.points[j];
        const Visibility sight = scene_.sight->Look(place, LargestJump_m(scene_.points.sigma_m[i]));
        ++seen;
        through += sight == Visibility::kSeenThrough;
        hidden += sight == Visibility::kHidden;
      }
    }
    return {static_cast<double>(through) / seen, static_cast<double>(hidden) / seen};
  }
  bool IsHiddenBetween(const Points& a, const Points& b) const {
    const Sight sight = Between(a, b);
    return sight.through <= kMostContradictions && sight.hidden >= kLeastHidden;
  }

  // Models the first with the points of the second.
  bool Join(std::size_t a, std::size_t b) {
    SegmentedThing &first = scene_.things[a], &second = scene_.things[b];
    const SegmentedThing before = first;
    const Points of_second = second.points;
    TakeOver(first, second);
    const auto is_one_solid = [](const ObjectModel& found) {
      return IsOneSolid(found.shapes, found.part_of_point, kLeastExplained);
    };
    std::optional<ModelledThing> joined =
        ModelThingIf(is_one_solid, scene_, a, SceneRays(scene_, work_), options_, work_);
    if (!joined || !AccountsFor(*joined, modelled_[a], before.points, scene_.points) ||
        !AccountsFor(*joined, modelled_[b], of_second, scene_.points)) {
      first = before;
      second.points = of_second;
      return false;
    }
    modelled_[a] = *std::move(joined);
    bounds_[a] = BoundsOf(modelled_[a]);
    bounds_.erase(bounds_.begin() + static_cast<std::ptrdiff_t>(b));
    RemoveThing(b, a, scene_, modelled_);
    return true;
  }

  const InterpretOptions& options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  int attempts_ = 0, returns_ = 0;
  std::size_t points_left_;
  bool any_joined_ = false, told_of_points_ = false;
};

}  // namespace

void JoinModelled(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                  std::vector<ModelledThing>& modelled) {
  if (scene.sight) Joiner(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
