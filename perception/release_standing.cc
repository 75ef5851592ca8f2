#include "perception/release_standing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/model/handles.h"
#include "perception/model/object_modeler.h"
#include "perception/order_things.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

// Each models a handle, and where that stands, the thing that it is released from anew. No simulated
// scene asks for more than seven, or has more than 0.4 of that many points in such things.
constexpr int kMostLooks = 8;
constexpr std::size_t kOneModelledAnew = 8;

constexpr double kLeastExplained = 0.96;  // of the points: a handle, too, is a bit of a cylinder
// From the ground to the lowest place: noise. Balls through handles of vessels are 12 mm off and more.
constexpr double kMostGap_m = 0.005;
constexpr double kUpright_cos = 0.98;  // 11 degrees: what is known as upright is exactly so

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
  const bool is_upright = std::abs(part.X_OS.linear().col(2).dot(up)) > kUpright_cos;
  return std::min(2 * radius_m, length_m) > kMostSeenHandleWidth_m &&
         (is_upright || length_m > 2 * radius_m);
}

// And touches what it stands on.
bool StandsRound(const ShapePart& part, const Pose& X_LSupport) {
  const Pose X_SupportS = X_LSupport.inverse(Eigen::Isometry) * part.X_OS;
  return IsRoundThing(part, X_LSupport.linear().col(2)) &&
         std::abs(TightBounds(part.shape, X_SupportS).min().z()) <= kMostGap_m;
}

class Release {
 public:
  Release(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
          std::vector<ModelledThing>& modelled)
      : options_(options),
        look_options_(options),
        work_(work),
        scene_(scene),
        modelled_(modelled),
        points_left_(scene.points.size() / kOneModelledAnew) {
    look_options_.modeler.part_touching = false;  // one solid is asked for
  }

  void Run() {
    const std::size_t before = scene_.things.size();
    for (std::size_t k = 0; k < CountObjects(scene_); ++k) {
      while (ReleaseOne(k)) {
      }
    }
    if (scene_.things.size() > before) SortBySize(scene_, modelled_);
  }

 private:
  // The first of the thing's handles that is a thing of its own.
  bool ReleaseOne(std::size_t k) {
    for (std::size_t h = 0; h < modelled_[k].model->handles.size(); ++h) {
      if (scene_.things[k].points.size() > points_left_) return false;
      if (looks_left_ == 0) {
        modelled_[k].notes.emplace_back(
            "a handle may be a thing of its own: the cap of looks was reached");
        return false;
      }
      --looks_left_;
      work_.Poll();
      if (IsReleased(k, h)) {
        points_left_ -= scene_.things[k].points.size();
        return true;
      }
    }
    return false;
  }

  bool IsReleased(std::size_t k, std::size_t handle) {
    const Points members = PointsOfHandle(k, handle);
    if (members.empty() || members.size() == scene_.things[k].points.size()) return false;
    if (!MayStand(members, scene_.things[k])) return false;
    const SegmentedThing before = scene_.things[k];
    SegmentedThing own = before;
    own.points = members;
    own.node_count = before.node_count * members.size() / before.points.size();
    SegmentedThing& host = scene_.things[k];
    host.node_count -= own.node_count;
    std::erase_if(host.points,
                  [&](std::uint32_t i) { return std::ranges::binary_search(members, i); });
    const auto place = static_cast<std::ptrdiff_t>(CountObjects(scene_));
    scene_.things.insert(scene_.things.begin() + place, std::move(own));
    const SceneRays rays(scene_, work_);
    const auto stands = [&](const ObjectModel& found) { return IsOneThatStands(found, before); };
    auto alone =
        ModelThingIf(stands, scene_, static_cast<std::size_t>(place), rays, look_options_, work_);
    if (!alone) {
      scene_.things.erase(scene_.things.begin() + place);
      scene_.things[k] = before;
      return false;
    }
    modelled_.insert(modelled_.begin() + place, *std::move(alone));
    modelled_[k] = ModelThing(scene_, k, rays, options_, work_);
    return true;
  }

  // Ascending, as a thing's points are.
  Points PointsOfHandle(std::size_t k, std::size_t handle) const {
    const auto part = static_cast<std::int32_t>(modelled_[k].model->shapes.size() + handle);
    Points members;
    for (std::size_t i = 0; i < modelled_[k].part_of_point.size(); ++i) {
      if (modelled_[k].part_of_point[i] == part) members.push_back(scene_.things[k].points[i]);
    }
    return members;
  }

  // Before it is modelled with all that was seen around it.
  bool MayStand(const Points& members, const SegmentedThing& thing) const {
    const Pose X_LSupport = *WhatItStandsOn(scene_, thing);
    const auto solid = ModelOneSolid(Subset(scene_.points, members), X_LSupport, options_.noise,
                                     look_options_.modeler, work_);
    return solid && StandsRound(*solid, X_LSupport);
  }

  bool IsOneThatStands(const ObjectModel& found, const SegmentedThing& thing) const {
    return IsOneSolid(found.shapes, found.part_of_point, kLeastExplained) &&
           StandsRound(found.shapes.front(), *WhatItStandsOn(scene_, thing));
  }

  const InterpretOptions& options_;
  InterpretOptions look_options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::size_t points_left_;
  int looks_left_ = kMostLooks;
};

}  // namespace

void ReleaseStanding(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                     std::vector<ModelledThing>& modelled) {
  Release(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
