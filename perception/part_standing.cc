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
#include "perception/scene/disjoint_sets.h"

namespace cwm::perception {
namespace {

using Points = std::vector<std::uint32_t>;

// Of so many points one may be modelled anew: what fills the view with noise is not modelled twice.
constexpr std::size_t kOneModelledAnew = 8;
constexpr double kLeastExplained = 0.9;  // of their points, as of any one solid
// From the ground to the lowest place: noise, and what a fit without a view of the foot is wrong by.
constexpr double kMostGap_m = 0.01;
// From one to the top of what it rests on, which its own foot hides.
constexpr double kMostStackedGap_m = 0.02;
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

bool IsVessel(const ShapePart& part) { return part.vessel != nullptr; }

// But for its handles, as those of vessels are.
bool IsOneThing(const ObjectModel& found) {
  if (IsOneSolid(found.shapes, found.part_of_point, kLeastExplained)) return true;
  const auto explained = std::ranges::count_if(
      found.part_of_point, [](std::int32_t part) { return part != kUnexplained; });
  return found.shapes.size() == 1 && IsVessel(found.shapes.front()) &&
         static_cast<double>(explained) >=
             kLeastExplained * static_cast<double>(found.part_of_point.size());
}

bool IsPartOfOneRod(const Cylinder& a, const Pose& X_OA, const Cylinder& b, const Pose& X_OB) {
  const Vector3 axis_a = X_OA.linear().col(2), axis_b = X_OB.linear().col(2);
  const double turn_cos = axis_a.dot(axis_b);
  const Vector3 between = (axis_a + (turn_cos < 0 ? -1 : 1) * axis_b).normalized();
  const Vector3 across = X_OB.translation() - X_OA.translation();
  return std::abs(a.radius_m - b.radius_m) < kMostStep_m && std::abs(turn_cos) > kMostTurn_cos &&
         across.cross(between).norm() < kMostOffAxis_m;
}

// Shells about one axis: the axis of each runs within the other.
bool IsPartOfOneVessel(const Aabb& a, const Aabb& b) {
  const double across_m = (a.center() - b.center()).head<2>().norm();
  return across_m < 0.5 * std::min(a.sizes().head<2>().minCoeff(), b.sizes().head<2>().minCoeff());
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

// Things that the solids of an object are, where they stand on what it stands on or on each other.
struct Things {
  std::vector<std::size_t> of_solid;  // which thing each solid is of
  std::vector<std::size_t>
      below;                   // which thing each one rests on; itself: what the object stands on
  std::vector<double> foot_m;  // how high that is
};

// Which of the solids this one rests on, itself where it stands on the ground; nothing where it does
// neither. Boxes alone are stacked: what is round and on something is its neck, its lid or its knob.
std::optional<std::size_t> Below(std::size_t solid, const std::vector<ShapePart>& shapes,
                                 const std::vector<Aabb>& bounds, const Pose& X_SupportO) {
  const double foot_m = bounds[solid].min().z();
  if (std::abs(foot_m) <= kMostGap_m) return solid;
  if (!std::holds_alternative<Box>(shapes[solid].shape)) return std::nullopt;
  Vector3 under = bounds[solid].center();
  for (std::size_t other = 0; other < shapes.size(); ++other) {
    const double top_m = bounds[other].max().z();
    if (other == solid || !std::holds_alternative<Box>(shapes[other].shape) ||
        std::abs(foot_m - top_m) > kMostStackedGap_m) {
      continue;
    }
    under.z() = top_m - kMostGap_m;
    const Pose X_OtherSupport = (X_SupportO * shapes[other].X_OS).inverse(Eigen::Isometry);
    if (SignedDistance_m(shapes[other], X_OtherSupport * under) < 0) return other;
  }
  return std::nullopt;
}

std::optional<Things> ThingsThatStand(const std::vector<ShapePart>& shapes,
                                      const Pose& X_SupportO) {
  if (shapes.size() < 2) return std::nullopt;
  if (!std::ranges::all_of(shapes, IsSolid) && !std::ranges::all_of(shapes, IsVessel)) {
    return std::nullopt;
  }
  std::vector<Aabb> bounds;
  for (const ShapePart& part : shapes) {
    bounds.push_back(TightBounds(part.shape, X_SupportO * part.X_OS));
  }
  std::vector<std::size_t> below;
  bool is_stack = false;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const std::optional<std::size_t> found = Below(k, shapes, bounds, X_SupportO);
    if (!found) return std::nullopt;
    is_stack |= *found != k;
    below.push_back(*found);
  }
  DisjointSets sets(shapes.size());
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    for (std::size_t b = a + 1; b < shapes.size(); ++b) {
      if (!CarriesOn(shapes[a], shapes[b], X_SupportO)) continue;
      // Side by side it tells that it is one thing; in a stack or of vessels, which solids are of one.
      if (!is_stack && !IsVessel(shapes[a])) return std::nullopt;
      sets.Join(a, b);
    }
  }
  Things things{std::vector<std::size_t>(shapes.size()), {}, {}};
  std::vector<std::size_t> first;  // solid of each thing
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    if (sets.Root(k) == k) things.of_solid[k] = first.size(), first.push_back(k);
    things.of_solid[k] = things.of_solid[sets.Root(k)];
  }
  if (first.size() < 2) return std::nullopt;
  for (std::size_t solid : first) {
    things.below.push_back(things.of_solid[below[solid]]);
    things.foot_m.push_back(below[solid] == solid ? 0 : bounds[below[solid]].max().z());
  }
  return things;
}

std::size_t Nearest(const ModelledThing& thing, const Vector3& p_L) {
  const Vector3 p_O = thing.X_LO.inverse(Eigen::Isometry) * p_L;
  std::vector<double> off_m;
  for (const ShapePart& part : thing.model->shapes) {
    off_m.push_back(std::abs(SignedDistance_m(part, part.X_OS.inverse(Eigen::Isometry) * p_O)));
  }
  return static_cast<std::size_t>(std::ranges::min_element(off_m) - off_m.begin());
}

// Of each thing, with those of no solid that lie nearest to it. Ascending, as a thing's points are.
std::vector<Points> PointsOfThings(const ModelledThing& thing, const Things& things,
                                   const Points& points, const OrientedPoints& all) {
  std::vector<Points> groups(things.below.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    auto part = static_cast<std::size_t>(thing.part_of_point[i]);
    if (part >= things.of_solid.size()) {  // unexplained, or a handle's
      part = Nearest(thing, all.points[points[i]].cast<double>());
    }
    groups[things.of_solid[part]].push_back(points[i]);
  }
  return groups;
}

// One thing, and what becomes of it: the first part in its place, the others as the last objects.
struct Parting {
  std::size_t place = 0;
  std::size_t others = 0;  // where they begin
  SegmentedThing whole;
  Things things = {};
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
      const auto things = ThingsThatStand(modelled_[k].model->shapes, X_SupportO(k));
      if (!things) continue;
      if (scene_.things[k].points.size() <= points_left_) {
        points_left_ -= scene_.things[k].points.size();
        Try(k, *things);
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

  void Try(std::size_t k, const Things& things) {
    std::vector<Points> groups =
        PointsOfThings(modelled_[k], things, scene_.things[k].points, scene_.points);
    if (std::ranges::any_of(groups, [](const Points& group) { return group.empty(); })) return;
    const Parting& parting =
        partings_.emplace_back(Parting{k, CountObjects(scene_), scene_.things[k], things});
    const SegmentedThing& whole = parting.whole;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      SegmentedThing part = whole;
      part.node_count = whole.node_count * groups[g].size() / whole.points.size();
      part.points = std::move(groups[g]);
      Stack(parting, g, part);
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
    const SceneRays rays(scene_, work_);
    ParallelFor(partings_.size(), 1, work_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Parting& parting = partings_[i];
        for (std::size_t part = 0; part < parting.anew.size(); ++part) {
          parting.anew[part] =
              ModelThingIf(IsOneThing, scene_, parting.PlaceOf(part), rays, options_, work_);
          if (!parting.anew[part]) break;
        }
      }
    });
  }

  // On the part below it, or on what the whole stands on.
  static void Stack(const Parting& parting, std::size_t part, SegmentedThing& thing) {
    const std::size_t below = parting.things.below[part];
    if (below == part) return;
    thing.rests_on = static_cast<std::int32_t>(parting.PlaceOf(below));
    thing.foot_height_m = parting.whole.foot_height_m + parting.things.foot_m[part];
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
    for (std::size_t k = 0; k < scene_.things.size(); ++k) {
      SegmentedThing& thing = scene_.things[k];
      const bool is_part = k == parting.place ||
                           (k >= parting.others && k + 1 < parting.others + parting.anew.size());
      if (is_part || thing.rests_on != static_cast<std::int32_t>(parting.place)) continue;
      const std::size_t solid = Nearest(modelled_[parting.place], FootOf(thing));
      thing.rests_on = static_cast<std::int32_t>(parting.PlaceOf(parting.things.of_solid[solid]));
    }
    for (std::size_t part = 0; part < parting.anew.size(); ++part) {
      Stack(parting, part, scene_.things[parting.PlaceOf(part)]);
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
  if (IsVessel(part) && IsVessel(other)) {
    return IsPartOfOneVessel(TightBounds(part.shape, X_SupportA),
                             TightBounds(other.shape, X_SupportB));
  }
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
