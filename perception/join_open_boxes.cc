#include "perception/join_open_boxes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "perception/cloud/quantile.h"
#include "perception/merge_things.h"
#include "perception/open_box.h"
#include "perception/order_things.h"
#include "perception/scene/plane_fit.h"
#include "perception/scene/surface_graph.h"

namespace cwm::perception {
namespace {

// That are looked at in a mouth and in a side, lines and places on each.
constexpr int kLines = 24, kPlaces = 12;
// Of the places in the mouth that are not hidden: the rest is what lies in it, up to its rim. Of all.
constexpr double kLeastThroughMouth = 0.9, kLeastOfMouth = 0.2;
constexpr double kBesideWall_m = 0.025;   // rays to the edge of a wall's inside pass it so near
constexpr double kMostThroughSide = 0.5;  // of a side that nobody saw
constexpr double kWall_m = 0.015;     // thickness of a wall and roundness of its rim: as of vessels
constexpr double kLeastOnBox = 0.8;   // of a thing's points: the rest are mixed pixels at rims
constexpr double kLeastWithin = 0.9;  // of what stands in it
constexpr std::size_t kFewestOnFloor = 36;  // three independent ones fix a plane

struct Joined {
  OpenBox box;
  Pose X_LB;
  std::size_t support = 0;
  std::vector<std::size_t> things;  // ascending
};

class OpenBoxJoiner {
 public:
  OpenBoxJoiner(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                std::vector<ModelledThing>& modelled)
      : options_(options), work_(work), scene_(scene), modelled_(modelled) {}

  std::vector<std::size_t> Run() {
    for (std::size_t s = 0; s < scene_.supports.size(); ++s) FindOn(s);
    std::vector<std::size_t> supports;
    std::vector<std::pair<std::size_t, std::size_t>> gone;  // and what they are parts of
    for (const Joined& joined : found_) {
      work_.Poll();
      Join(joined);
      supports.push_back(joined.support);
      for (std::size_t k = 1; k < joined.things.size(); ++k) {
        gone.emplace_back(joined.things[k], joined.things.front());
      }
    }
    // The last first: what they are parts of comes before them and keeps its place.
    std::ranges::sort(gone, std::greater());
    for (const auto& [thing, whole] : gone) RemoveThing(thing, whole, scene_, modelled_);
    if (!found_.empty()) SortBySize(scene_, modelled_);
    supports.erase(std::unique(supports.begin(), supports.end()), supports.end());
    return supports;
  }

 private:
  void FindOn(std::size_t support) {
    const Pose& X_LP = scene_.supports[support].plate.X_FS;
    const Pose X_PL = X_LP.inverse(Eigen::Isometry);
    const Vector3 sensor_P = X_PL * scene_.points.viewpoint;
    std::vector<LoneWall> walls;
    std::vector<std::size_t> thing_of_wall;
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      if (scene_.things[k].supported_by != static_cast<std::int32_t>(support)) continue;
      for (const ShapePart& part : modelled_[k].model->shapes) {
        const auto wall = AsLoneWall(part, X_PL * modelled_[k].X_LO, sensor_P);
        if (!wall) continue;
        walls.push_back(*wall);
        thing_of_wall.push_back(k);
      }
    }
    for (OpenBox& box : FindOpenBoxes(walls, sensor_P)) {
      work_.Poll();
      const Pose X_LB = X_LP * box.X_PB;
      Joined joined{.box = std::move(box), .X_LB = X_LB, .support = support, .things = {}};
      if (!IsMouthOpen(joined) || !AreWallsWhole(joined)) continue;
      if (!CollectThings(joined, thing_of_wall)) continue;
      for (std::size_t k : joined.things) taken_.push_back(k);
      found_.push_back(std::move(joined));
    }
  }

  float Sigma_m(std::size_t thing) const {
    return scene_.points.sigma_m[scene_.things[thing].points.front()];
  }

  struct Sight {
    int through = 0, on = 0, all = 0;

    void Add(const Sight& other) {
      through += other.through;
      on += other.on;
      all += other.all;
    }
  };

  // At kPlaces of a line.
  Sight LookAlong(const Vector3& begin_L, const Vector3& line_L) const {
    Sight sight;
    for (int k = 0; k < kPlaces; ++k) {
      const Vector3 place = begin_L + (k + 0.5) / kPlaces * line_L;
      const double range_m = (place - scene_.points.viewpoint).norm();
      const auto sigma_m = static_cast<float>(options_.noise.AxialSigma_m(range_m));
      const Visibility seen = scene_.sight->Look(place.cast<float>(), kPlaneGate_sigma * sigma_m);
      ++sight.all;
      sight.through += seen == Visibility::kSeenThrough;
      sight.on += seen == Visibility::kOnSurface;
    }
    return sight;
  }

  // Of a rectangle, along each of some lines that are parallel to its y.
  std::vector<Sight> LookAt(const Vector3& corner_L, const Vector3& x_L, const Vector3& y_L) const {
    std::vector<Sight> sights;
    for (int k = 0; k < kLines; ++k) {
      sights.push_back(LookAlong(corner_L + (k + 0.5) / kLines * x_L, y_L));
    }
    return sights;
  }

  // Anything closed would be seen there, as high as the walls.
  bool IsMouthOpen(const Joined& joined) const {
    const OpenBox& box = joined.box;
    const Vector2 size_m =
        box.size_m - 2 * Vector2::Constant(kBesideWall_m).cwiseMin(0.25 * box.size_m);
    const Vector3 corner(-0.5 * size_m.x(), -0.5 * size_m.y(), box.rim_m);
    const Matrix3 axes = joined.X_LB.linear();
    Sight sight;
    for (const Sight& line :
         LookAt(joined.X_LB * corner, size_m.x() * axes.col(0), size_m.y() * axes.col(1))) {
      sight.Add(line);
    }
    return sight.through >= kLeastThroughMouth * (sight.through + sight.on) &&
           sight.through >= kLeastOfMouth * sight.all;
  }

  // Along each of some upright lines.
  std::vector<Sight> LookAtSide(const Joined& joined, std::size_t side) const {
    const OpenBox& box = joined.box;
    const auto axis = static_cast<Eigen::Index>(side / 2);
    const double length_m =
        box.size_m(1 - axis) - 2 * std::min(kBesideWall_m, 0.25 * box.size_m(1 - axis));
    Vector3 corner = Vector3::Zero();
    corner(axis) = (side % 2 == 0 ? 0.5 : -0.5) * box.size_m(axis);
    corner(1 - axis) = -0.5 * length_m;
    const Matrix3 axes = joined.X_LB.linear();
    return LookAt(joined.X_LB * corner, length_m * axes.col(1 - axis), box.rim_m * axes.col(2));
  }

  // Whether its pieces are not one wall: rays pass from near its foot, where what it stands on is as
  // near, to its rim. A hole to hold it by is lower.
  bool HasGap(const Joined& joined, std::size_t side) const {
    return std::ranges::any_of(LookAtSide(joined, side),
                               [](const Sight& line) { return 2 * line.through > line.all; });
  }

  bool IsSideOpen(const Joined& joined, std::size_t side) const {
    Sight sight;
    for (const Sight& line : LookAtSide(joined, side)) sight.Add(line);
    return sight.through > kMostThroughSide * sight.all;
  }

  bool AreWallsWhole(const Joined& joined) const {
    for (std::size_t k = 0; k < joined.box.sides.size(); ++k) {
      if (joined.box.sides[k].in_pieces && HasGap(joined, k)) return false;
    }
    return true;
  }

  // Within a wall's thickness of the sides, or on the floor as far as that can show off the support.
  double ShareOnBox(const Joined& joined, std::size_t thing) const {
    const Pose X_BL = joined.X_LB.inverse(Eigen::Isometry);
    const double floor_m = OrientedPoints::OffPlane_m(scene_.points.spread.usual, Sigma_m(thing));
    const std::vector<Eigen::Vector3f>& points = modelled_[thing].thinned_L;
    const auto on = std::ranges::count_if(points, [&](const Eigen::Vector3f& p) {
      const Vector3 p_B = X_BL * p.cast<double>();
      if (p_B.z() > joined.box.rim_m + kWall_m) return false;
      return joined.box.ToSides_m(p_B) <= kWall_m || (joined.box.IsOver(p_B) && p_B.z() <= floor_m);
    });
    return static_cast<double>(on) / static_cast<double>(points.size());
  }

  // What lies on the box. Nothing where a wall belongs to something that does not.
  bool CollectThings(Joined& joined, const std::vector<std::size_t>& thing_of_wall) const {
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      const std::int32_t on = scene_.things[k].supported_by;
      if (on >= 0 && on != static_cast<std::int32_t>(joined.support)) continue;
      if (!scene_.things[k].plates.empty() || modelled_[k].thinned_L.empty()) continue;
      if (std::ranges::count(taken_, k) > 0) continue;
      if (ShareOnBox(joined, k) >= kLeastOnBox) joined.things.push_back(k);
    }
    return std::ranges::all_of(joined.box.walls, [&](std::size_t wall) {
      return std::ranges::binary_search(joined.things, thing_of_wall[wall]);
    });
  }

  void Join(const Joined& joined) {
    const Pose X_BL = joined.X_LB.inverse(Eigen::Isometry);
    const std::size_t first = joined.things.front();
    SegmentedThing& whole = scene_.things[first];
    for (std::size_t k = 1; k < joined.things.size(); ++k) {
      TakeOver(whole, scene_.things[joined.things[k]]);
    }
    whole.foot_height_m = 0;
    whole.rests_on = -1;
    const std::size_t of_things = whole.points.size();
    std::erase_if(scene_.supports[joined.support].points, [&](std::uint32_t i) {
      if (!joined.box.IsOver(X_BL * scene_.points.points[i].cast<double>())) return false;
      whole.points.push_back(i);
      return true;
    });
    whole.node_count = whole.node_count * whole.points.size() / of_things;
    std::ranges::sort(whole.points);
    std::vector<double> heights_m = HeightsOfFloor(joined, whole.points);
    const bool sees_floor = heights_m.size() >= kFewestOnFloor;
    const double floor_m = sees_floor ? Quantile(std::move(heights_m), 0.5) : 0;
    std::array<Made, 4> sides{};
    for (std::size_t k = 0; k < sides.size(); ++k) {
      sides[k] = joined.box.sides[k].is_seen ? Made::kSeen
                 : IsSideOpen(joined, k)     ? Made::kNot
                                             : Made::kCompleted;
    }
    const Pose X_LP = joined.X_LB * joined.box.X_PB.inverse(Eigen::Isometry);
    std::vector<ShapePart> parts =
        PartsOf(joined.box, sides, floor_m, sees_floor ? Made::kSeen : Made::kCompleted);
    for (ShapePart& part : parts) part.X_OS = X_LP * part.X_OS;
    modelled_[first] = ModelThingAs(std::move(parts), scene_, first, options_, work_);
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      if (k != first && StandsIn(joined, k, X_BL, floor_m)) {
        scene_.things[k].rests_on = static_cast<std::int32_t>(first);
        scene_.things[k].foot_height_m = std::max(0.0, floor_m);
      }
    }
  }

  // Of what is within the sides and no higher than a floor can show off the support.
  std::vector<double> HeightsOfFloor(const Joined& joined,
                                     const std::vector<std::uint32_t>& points) const {
    const Pose X_BL = joined.X_LB.inverse(Eigen::Isometry);
    std::vector<double> heights_m;
    for (std::uint32_t i : points) {
      const Vector3 p_B = X_BL * scene_.points.points[i].cast<double>();
      if (!joined.box.IsOver(p_B) || joined.box.ToSides_m(p_B) <= kWall_m) continue;
      if (p_B.z() <= double{scene_.points.UsuallyOffPlane_m(i)}) heights_m.push_back(p_B.z());
    }
    return heights_m;
  }

  bool StandsIn(const Joined& joined, std::size_t thing, const Pose& X_BL, double floor_m) const {
    const SegmentedThing& it = scene_.things[thing];
    if (it.supported_by != static_cast<std::int32_t>(joined.support)) return false;
    if (it.rests_on >= 0) return false;
    if (it.points.empty() || modelled_[thing].thinned_L.empty()) return false;
    std::size_t within = 0;
    double foot_m = joined.box.rim_m;
    for (const Eigen::Vector3f& p : modelled_[thing].thinned_L) {
      const Vector3 p_B = X_BL * p.cast<double>();
      within += joined.box.IsOver(p_B);
      foot_m = std::min(foot_m, p_B.z());
    }
    return static_cast<double>(within) >=
               kLeastWithin * static_cast<double>(modelled_[thing].thinned_L.size()) &&
           foot_m <= floor_m + double{LargestJump_m(Sigma_m(thing))};
  }

  const InterpretOptions& options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::vector<Joined> found_;
  std::vector<std::size_t> taken_;  // things
};

}  // namespace

std::vector<std::size_t> JoinOpenBoxes(const InterpretOptions& options, const Work& work,
                                       SegmentedScene& scene,
                                       std::vector<ModelledThing>& modelled) {
  if (!scene.sight || options.clustering == Clustering::kNone) return {};
  return OpenBoxJoiner(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
