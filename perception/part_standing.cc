#include "perception/part_standing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "collision/geometry/aabb.h"
#include "perception/cloud/parallel_for.h"
#include "perception/order_things.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

// Of so many points one may be modelled anew: what fills the view with noise is not modelled twice.
constexpr std::size_t kOneModelledAnew = 8;
constexpr double kLeastExplained = 0.9;  // of their points, as of any one solid
// From the ground to the lowest place: noise, and what a fit without a view of the foot is wrong by.
constexpr double kMostGap_m = 0.01;
// A box as thin as that may be one face of another.
constexpr double kLeastThickness_m = 0.02;

// Of surfaces that carry each other on, bent as soft packages are, and warped as all things are seen.
constexpr double kMostStep_m = 0.005;
constexpr double kMostOffAxis_m = 0.01;
constexpr double kMostTurn_cos = 0.966;  // 15 degrees

// Of a closed solid: faces alone are of the thing that they are found on.
bool IsSolid(const ShapePart& part) {
  if (part.vessel || std::holds_alternative<Plate>(part.shape)) return false;
  const auto* box = std::get_if<Box>(&part.shape);
  return box == nullptr || box->size_m.minCoeff() > kLeastThickness_m;
}

bool IsPartOfOneRod(const Cylinder& a, const Pose& X_OA, const Cylinder& b, const Pose& X_OB) {
  const Vector3 axis_a = X_OA.linear().col(2), axis_b = X_OB.linear().col(2);
  const double turn_cos = axis_a.dot(axis_b);
  const Vector3 between = (axis_a + (turn_cos < 0 ? -1 : 1) * axis_b).normalized();
  const Vector3 across = X_OB.translation() - X_OA.translation();
  return std::abs(a.radius_m - b.radius_m) < kMostStep_m && std::abs(turn_cos) > kMostTurn_cos &&
         across.cross(between).norm() < kMostOffAxis_m;
}

// Both stand on the same ground.
bool IsPartOfOneBlock(const Box& a, const Pose& X_SupportA, const Box& b, const Pose& X_SupportB) {
  const auto top_m = [](const Box& box, const Pose& X_SupportB) {
    return TightBounds(box, X_SupportB).max().z();
  };
  const Matrix3 turns = (X_SupportA.linear().transpose() * X_SupportB.linear()).cwiseAbs();
  return std::abs(top_m(a, X_SupportA) - top_m(b, X_SupportB)) < kMostStep_m &&
         turns.rowwise().maxCoeff().minCoeff() > kMostTurn_cos;
}

bool AreThingsThatStand(const std::vector<ShapePart>& shapes, const Pose& X_SupportO) {
  if (shapes.size() < 2) return false;
  for (auto part = shapes.begin(); part != shapes.end(); ++part) {
    const double gap_m = std::abs(TightBounds(part->shape, X_SupportO * part->X_OS).min().z());
    if (!IsSolid(*part) || gap_m > kMostGap_m) return false;
    if (std::any_of(part + 1, shapes.end(),
                    [&](const ShapePart& other) { return CarriesOn(*part, other, X_SupportO); })) {
      return false;
    }
  }
  return true;
}

std::size_t Nearest(const ModelledThing& thing, const Vector3& p_L) {
  const Vector3 p_O = thing.X_LO.inverse(Eigen::Isometry) * p_L;
  std::vector<double> off_m;
  for (const ShapePart& part : thing.model->shapes) {
    off_m.push_back(std::abs(SignedDistance_m(part, part.X_OS.inverse(Eigen::Isometry) * p_O)));
  }
  return static_cast<std::size_t>(std::ranges::min_element(off_m) - off_m.begin());
}

// Of each solid, with those of the others that lie nearest to it. Ascending, as a thing's points are.
std::vector<Points> PointsOfSolids(const ModelledThing& thing, const Points& points,
                                   const OrientedPoints& all) {
  std::vector<Points> groups(thing.model->shapes.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    auto part = static_cast<std::size_t>(thing.part_of_point[i]);
    if (part >= groups.size()) {  // unexplained, or a handle's
      part = Nearest(thing, all.points[points[i]].cast<double>());
    }
    groups[part].push_back(points[i]);
  }
  return groups;
}

// One thing, and what becomes of it: the first part in its place, the others as the last objects.
struct Parting {
  std::size_t place = 0;
  std::size_t others = 0;  // where they begin
  SegmentedThing whole;
  std::vector<std::optional<ModelledThing>> anew = {};  // of each part; nothing: no single solid

  std::size_t PlaceOf(std::size_t part) const { return part == 0 ? place : others + part - 1; }
  bool holds() const {
    return std::ranges::all_of(anew, [](const auto& model) { return model.has_value(); });
  }
};

class Parter {
 public:
  Parter(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
         std::vector<ModelledThing>& modelled)
      : options_(options),
        work_(work),
        scene_(scene),
        modelled_(modelled),
        points_left_(scene.points.size() / kOneModelledAnew) {
    options_.modeler.part_touching = false;  // one solid is asked for
  }

  void Run() {
    const std::size_t objects = CountObjects(scene_);
    for (std::size_t k = 0; k < objects; ++k) {
      work_.Poll();
      if (!AreThingsThatStand(modelled_[k].model->shapes, X_SupportO(k))) continue;
      if (scene_.things[k].points.size() <= points_left_) {
        points_left_ -= scene_.things[k].points.size();
        Try(k);
      } else if (!std::exchange(told_of_points_, true)) {
        modelled_[k].notes.emplace_back(
            "its shapes may be things of their own: the cap of points of parts was reached");
      }
    }
    if (partings_.empty()) return;
    Model();
    std::size_t taken_back = 0;
    for (Parting& parting : partings_) {
      parting.others -= taken_back;
      if (parting.holds()) {
        Keep(parting);
      } else {
        TakeBack(parting);
        taken_back += parting.anew.size() - 1;
      }
    }
    SortBySize(scene_, modelled_);
  }

 private:
  Pose X_SupportO(std::size_t k) const {
    return WhatItStandsOn(scene_, scene_.things[k])->inverse(Eigen::Isometry) * modelled_[k].X_LO;
  }

  void Try(std::size_t k) {
    std::vector<Points> groups =
        PointsOfSolids(modelled_[k], scene_.things[k].points, scene_.points);
    if (std::ranges::any_of(groups, [](const Points& group) { return group.empty(); })) return;
    const SegmentedThing& whole =
        partings_.emplace_back(Parting{k, CountObjects(scene_), scene_.things[k]}).whole;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      SegmentedThing part = whole;
      part.node_count = whole.node_count * groups[g].size() / whole.points.size();
      part.points = std::move(groups[g]);
      if (g == 0) {
        scene_.things[k] = std::move(part);
      } else {
        const std::size_t end = CountObjects(scene_);
        scene_.things.insert(scene_.things.begin() + static_cast<std::ptrdiff_t>(end),
                             std::move(part));
      }
    }
    partings_.back().anew.resize(groups.size());
  }

  void Model() {
    const auto is_one_solid = [](const ObjectModel& found) {
      return IsOneSolid(found.shapes, found.part_of_point, kLeastExplained);
    };
    const SceneRays rays(scene_, work_);
    ParallelFor(partings_.size(), 1, work_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Parting& parting = partings_[i];
        for (std::size_t part = 0; part < parting.anew.size(); ++part) {
          parting.anew[part] =
              ModelThingIf(is_one_solid, scene_, parting.PlaceOf(part), rays, options_, work_);
          if (!parting.anew[part]) break;
        }
      }
    });
  }

  void TakeBack(Parting& parting) {
    const auto others = scene_.things.begin() + static_cast<std::ptrdiff_t>(parting.others);
    scene_.things.erase(others, others + static_cast<std::ptrdiff_t>(parting.anew.size() - 1));
    scene_.things[parting.place] = std::move(parting.whole);
  }

  // Where it stands, below the middle of its points.
  Vector3 FootOf(const SegmentedThing& thing) const {
    Vector3 middle_L = Vector3::Zero();
    for (std::uint32_t i : thing.points) middle_L += scene_.points.points[i].cast<double>();
    const Pose X_LFoot = *WhatItStandsOn(scene_, thing);
    Vector3 foot =
        X_LFoot.inverse(Eigen::Isometry) * (middle_L / static_cast<double>(thing.points.size()));
    foot.z() = 0;
    return X_LFoot * foot;
  }

  void Keep(Parting& parting) {
    for (SegmentedThing& thing : scene_.things) {
      if (thing.rests_on != static_cast<std::int32_t>(parting.place)) continue;
      const std::size_t part = Nearest(modelled_[parting.place], FootOf(thing));
      thing.rests_on = static_cast<std::int32_t>(parting.PlaceOf(part));
    }
    modelled_[parting.place] = *std::move(parting.anew.front());
    for (std::size_t part = 1; part < parting.anew.size(); ++part) {
      modelled_.insert(modelled_.begin() + static_cast<std::ptrdiff_t>(parting.PlaceOf(part)),
                       *std::move(parting.anew[part]));
    }
  }

  InterpretOptions options_;
  const Work& work_;
  SegmentedScene& scene_;
  std::vector<ModelledThing>& modelled_;
  std::size_t points_left_;
  bool told_of_points_ = false;
  std::vector<Parting> partings_;
};

}  // namespace

bool CarriesOn(const ShapePart& part, const ShapePart& other, const Pose& X_SupportO) {
  const Pose X_SupportA = X_SupportO * part.X_OS, X_SupportB = X_SupportO * other.X_OS;
  if (const auto* a = std::get_if<Cylinder>(&part.shape), *b = std::get_if<Cylinder>(&other.shape);
      a && b) {
    return IsPartOfOneRod(*a, X_SupportA, *b, X_SupportB);
  }
  if (const auto* a = std::get_if<Box>(&part.shape), *b = std::get_if<Box>(&other.shape); a && b) {
    return IsPartOfOneBlock(*a, X_SupportA, *b, X_SupportB);
  }
  return false;
}

void PartStanding(const InterpretOptions& options, const Work& work, SegmentedScene& scene,
                  std::vector<ModelledThing>& modelled) {
  Parter(options, work, scene, modelled).Run();
}

}  // namespace cwm::perception
