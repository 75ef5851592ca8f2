#include "perception/trade_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "perception/cloud/parallel_for.h"
#include "perception/merge_things.h"
#include "perception/model/seen_width.h"
#include "perception/model/slenderness.h"
#include "perception/model/vessel_handles.h"
#include "perception/order_things.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

// Each models two things anew; of so many points one may be.
constexpr int kMostTrades = 8;
constexpr std::size_t kOneModelledAnew = 4;
// Between things that touch, less than the roundness of a mug's wall hides.
constexpr double kMostApart_m = 0.03;
constexpr double kOwnEnds_m = 0.01;  // by so much the ends of a handle are nearer to its own wall

bool IsVessel(const ModelledThing& thing) {
  return std::ranges::any_of(thing.model->shapes,
                             [](const ShapePart& part) { return part.vessel != nullptr; });
}

class Trader {
 public:
  Trader(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
         std::vector<ModelledThing>& modelled)
      : options_(options),
        work_(work),
        scene_(scene),
        modelled_(modelled),
        points_left_(scene.points.size() / kOneModelledAnew) {}

  void Run() {
    bool any = false;
    const std::size_t objects = CountObjects(scene_);
    for (std::size_t k = 0; k < objects; ++k) bounds_.push_back(BoundsOf(modelled_[k]));
    for (std::size_t from = 0; from < objects; ++from) {
      for (std::size_t to = 0; to < objects; ++to) {
        if (from == to || bounds_[from].exteriorDistance(bounds_[to]) > kMostApart_m) continue;
        if (modelled_[to].model->shapes.empty()) continue;
        work_.Poll();
        const Points given = GivenTo(to, from);
        if (given.size() < kLeastHandlePoints ||
            given.size() == scene_.things[from].points.size()) {
          continue;
        }
        if (trades_left_ == 0 || !MaySpend(from, to)) {
          modelled_[from].notes.emplace_back(
              "parts of it may belong to what touches it: the cap of trades was reached");
          break;
        }
        --trades_left_;
        any |= Trade(given, from, to);
      }
    }
    if (any) SortBySize(scene_, modelled_);
  }

 private:
  bool MaySpend(std::size_t a, std::size_t b) {
    const std::size_t points = scene_.things[a].points.size() + scene_.things[b].points.size();
    if (points > points_left_) return false;
    points_left_ -= points;
    return true;
  }

  // From the surface of the nearest of its shapes.
  double Off_m(const ModelledThing& thing, const Vector3& p_L) const {
    double off_m = std::numeric_limits<double>::infinity();
    for (const ShapePart& part : thing.model->shapes) {
      const Vector3 p_S = (thing.X_LO * part.X_OS).inverse(Eigen::Isometry) * p_L;
      off_m = std::min(off_m, std::abs(SignedDistance_m(part, p_S)));
    }
    return off_m;
  }

  // Ascending, as a thing's points are.
  Points GivenTo(std::size_t to, std::size_t from) const {
    const ModelledThing& thing = modelled_[from];
    const auto shapes = static_cast<std::int32_t>(thing.model->shapes.size());
    std::vector<Points> handles(thing.model->handles.size());
    Points given;
    for (std::size_t k = 0; k < thing.part_of_point.size(); ++k) {
      const std::uint32_t i = scene_.things[from].points[k];
      const std::int32_t part = thing.part_of_point[k];
      if (part >= shapes) {
        handles[static_cast<std::size_t>(part - shapes)].push_back(i);
      } else if (part < 0 && Off_m(modelled_[to], scene_.points.points[i].cast<double>()) <=
                                 ExplainedWithin_m(scene_.points.sigma_m[i])) {
        given.push_back(i);
      }
    }
    if (!IsVessel(modelled_[to])) handles.clear();
    for (const Points& handle : handles) {
      if (IsHandleOf(to, from, handle)) given.insert(given.end(), handle.begin(), handle.end());
    }
    std::ranges::sort(given);
    return given;
  }

  // Whether both its ends, together, are nearer to the one than to the other.
  bool IsHandleOf(std::size_t to, std::size_t from, const Points& handle) const {
    if (handle.empty()) return false;
    std::vector<Eigen::Vector3f> places;
    for (std::uint32_t i : handle) places.push_back(scene_.points.points[i]);
    const Vector3& viewpoint = scene_.points.viewpoint;
    const Slenderness bar = MeasureSlenderness(places, viewpoint, SeenPitch_m(places, viewpoint));
    double nearer_m = 0;
    for (const Vector3& end : bar.ends) {
      nearer_m += Off_m(modelled_[from], end) - Off_m(modelled_[to], end);
    }
    return nearer_m > kOwnEnds_m;
  }

  static std::size_t WithoutShape(const ModelledThing& thing, const Points& points,
                                  const Points& given) {
    const auto shapes = static_cast<std::int32_t>(thing.model->shapes.size());
    std::size_t without = 0;
    for (std::size_t k = 0; k < thing.part_of_point.size(); ++k) {
      const std::int32_t part = thing.part_of_point[k];
      without += part < 0 ||
                 (part >= shapes && !given.empty() && std::ranges::binary_search(given, points[k]));
    }
    return without;
  }

  // Which may have been none.
  std::size_t HandlesAmong(const Points& given, std::size_t from, const Points& points) const {
    const ModelledThing& thing = modelled_[from];
    const auto shapes = static_cast<std::int32_t>(thing.model->shapes.size());
    std::vector<char> among(thing.model->handles.size(), 0);
    for (std::size_t k = 0; k < thing.part_of_point.size(); ++k) {
      const std::int32_t part = thing.part_of_point[k];
      if (part >= shapes && std::ranges::binary_search(given, points[k])) {
        among[static_cast<std::size_t>(part - shapes)] = 1;
      }
    }
    return static_cast<std::size_t>(std::ranges::count(among, 1));
  }

  // True where it is kept.
  bool Trade(const Points& given, std::size_t from, std::size_t to) {
    const SegmentedThing before_from = scene_.things[from], before_to = scene_.things[to];
    SegmentedThing &giver = scene_.things[from], &taker = scene_.things[to];
    GivePoints(given, giver, taker);
    const SceneRays rays(scene_, work_);
    ModelledThing anew_from, anew_to;
    DoBoth(
        work_, [&] { anew_from = ModelThing(scene_, from, rays, options_, work_); },
        [&] { anew_to = ModelThing(scene_, to, rays, options_, work_); });
    // A handle of the wrong one has no shape.
    const std::size_t before = WithoutShape(modelled_[from], before_from.points, given) +
                               WithoutShape(modelled_[to], {}, {});
    const std::size_t after = WithoutShape(anew_from, {}, {}) + WithoutShape(anew_to, {}, {});
    const std::size_t handles_before =
        modelled_[from].model->handles.size() + modelled_[to].model->handles.size();
    const std::size_t handles_after =
        anew_from.model->handles.size() + anew_to.model->handles.size();
    if (2 * (before - std::min(before, after)) < given.size() ||
        handles_after + HandlesAmong(given, from, before_from.points) < handles_before) {
      giver = before_from;
      taker = before_to;
      return false;
    }
    modelled_[from] = std::move(anew_from);
    modelled_[to] = std::move(anew_to);
    bounds_[from] = BoundsOf(modelled_[from]);
    bounds_[to] = BoundsOf(modelled_[to]);
    return true;
  }

  const InterpretOptions& options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::vector<Eigen::AlignedBox3f> bounds_;
  int trades_left_ = kMostTrades;
  std::size_t points_left_;
};

}  // namespace

void TradePoints(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                 std::vector<ModelledThing>& modelled) {
  Trader(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
