#include "collision/query/sphere_scene.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "collision/query/body_search.h"
#include "collision/query/hidden_spaces.h"

namespace cwm::collision {
namespace {

// derived: axes this near to the coordinate axes are replaced by them, since 1e-9 of a coordinate
// is far below its rounding in single precision (Rounding_m).
constexpr double kAlignmentTolerance = 1e-9;

// An obstacle before its conversion to single precision: a form of given size, centred at X_BS.
struct Solid {
  Pose X_BS = Pose::Identity();
  LaneObstacle::Form form = LaneObstacle::Form::kBox;
  Vector3 size_m = Vector3::Zero();
  bool is_hull = false;
  bool is_bounded = true;
};

Solid Around(const PreparedPart& part, const Pose& X_BS) {
  const Pose X_BO = X_BS * part.X_OP.inverse();
  Solid solid;
  solid.is_hull = true;
  solid.X_BS = X_BO;
  solid.X_BS.translation() = X_BO * part.bounds_O.center();
  solid.size_m = 0.5 * part.bounds_O.sizes();
  return solid;
}

Solid SolidOf(const PreparedPart& part, const Pose& X_BS) {
  using Form = LaneObstacle::Form;
  Solid solid;
  solid.X_BS = X_BS;
  if (const auto* box = std::get_if<Box>(&part.shape)) {
    solid.size_m = 0.5 * box->size_m;
  } else if (const auto* sphere = std::get_if<Sphere>(&part.shape)) {
    solid.form = Form::kRound;
    solid.size_m = {sphere->radius_m, 0, 0};
  } else if (const auto* capsule = std::get_if<Capsule>(&part.shape)) {
    solid.form = Form::kRound;
    solid.size_m = {capsule->radius_m, 0.5 * capsule->length_m, 0};
  } else if (const auto* cylinder = std::get_if<Cylinder>(&part.shape)) {
    solid.form = Form::kCylinder;
    solid.size_m = {cylinder->radius_m, 0.5 * cylinder->length_m, 0};
  } else if (const auto* cone = std::get_if<Cone>(&part.shape)) {
    solid.form = Form::kCylinder;
    solid.size_m = {std::max(cone->radius_bottom_m, cone->radius_top_m), 0.5 * cone->length_m, 0};
    solid.is_hull = true;
  } else if (std::holds_alternative<HalfSpace>(part.shape)) {
    solid.form = Form::kHalfSpace;
    solid.is_bounded = false;
  } else {
    return Around(part, X_BS);
  }
  return solid;
}

// Cuts a box, cylinder or capsule along its axes to the part that can contain the nearest point to
// a sphere's centre, so that no number is much larger than the robot's reach.
void Clip(double reach_m, Solid& solid) {
  const Vector3 root_S = solid.X_BS.linear().transpose() * -solid.X_BS.translation();
  const auto clip = [&](int axis, double& half_m) {
    const double low = std::max(-half_m, root_S[axis] - reach_m);
    const double high = std::min(half_m, root_S[axis] + reach_m);
    if (low > high || high - low >= 2 * half_m) return;
    half_m = 0.5 * (high - low);
    solid.X_BS.translation() += solid.X_BS.linear().col(axis) * (0.5 * (high + low));
  };
  switch (solid.form) {
    case LaneObstacle::Form::kBox:
      for (int axis = 0; axis < 3; ++axis) clip(axis, solid.size_m[axis]);
      break;
    case LaneObstacle::Form::kCylinder:
    case LaneObstacle::Form::kRound:
      clip(2, solid.size_m[1]);
      break;
    case LaneObstacle::Form::kHalfSpace:
      break;
  }
}

// The distance of a point from the solid; 0 inside.
double Distance_m(const Solid& solid, const Vector3& p_B) {
  const Vector3 p = solid.X_BS.linear().transpose() * (p_B - solid.X_BS.translation());
  const double across_m = p.head<2>().norm(),
               above_m = std::max(std::abs(p.z()) - solid.size_m[1], 0.0);
  switch (solid.form) {
    case LaneObstacle::Form::kBox:
      return (p.cwiseAbs() - solid.size_m).cwiseMax(0.0).norm();
    case LaneObstacle::Form::kCylinder:
      return Vector2(std::max(across_m - solid.size_m[0], 0.0), above_m).norm();
    case LaneObstacle::Form::kRound:
      return std::max(Vector2(across_m, above_m).norm() - solid.size_m[0], 0.0);
    case LaneObstacle::Form::kHalfSpace:
      break;
  }
  return std::max(p.z(), 0.0);
}

// True if an axis is parallel to a coordinate axis, up to kAlignmentTolerance and in either
// direction.
bool IsAlignedWith(const Matrix3& axes, int axis) {
  return (axes.col(axis).cwiseAbs().array() > kAlignmentTolerance).count() == 1;
}

// Replaces the solid's axes by the coordinate axes if they differ only by right angles or by a
// symmetry of the form. False if they do not.
bool Align(Solid& solid) {
  const Matrix3 axes = solid.X_BS.linear();
  const bool is_upright = IsAlignedWith(axes, 2) && std::abs(axes(2, 2)) > 0.5;
  switch (solid.form) {
    case LaneObstacle::Form::kBox:
      if (!IsAlignedWith(axes, 0) || !IsAlignedWith(axes, 1) || !IsAlignedWith(axes, 2))
        return false;
      solid.size_m = axes.cwiseAbs().array().round().matrix() * solid.size_m;
      break;
    case LaneObstacle::Form::kRound:
      if (!is_upright && solid.size_m[1] > 0) return false;
      break;
    case LaneObstacle::Form::kCylinder:
      if (!is_upright) return false;
      break;
    case LaneObstacle::Form::kHalfSpace:
      if (!is_upright || axes(2, 2) < 0) return false;
      // A half-space has no centre; only the coordinate across the plane is kept, so that large
      // ones along the plane cause no rounding.
      solid.X_BS.translation() = Vector3::UnitZ() * axes.col(2).dot(solid.X_BS.translation());
      break;
  }
  solid.X_BS.linear().setIdentity();
  return true;
}

LaneObstacle InLanes(Solid solid, double margin_m) {
  LaneObstacle lanes{.form = solid.form, .is_hull = solid.is_hull, .is_aligned = Align(solid)};
  const Matrix3 axes = solid.X_BS.linear().transpose();
  const Vector3 offset = axes * solid.X_BS.translation();
  for (int i = 0; i < 9; ++i) lanes.axis[i] = static_cast<float>(axes(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) lanes.offset_m[i] = static_cast<float>(offset[i]);
  for (int i = 0; i < 3; ++i) lanes.size_m[i] = static_cast<float>(solid.size_m[i]);
  lanes.margin_m = static_cast<float>(margin_m);
  return lanes;
}

// The axes that most boxes share up to right angles, as those of shelves, tables and rooms do. The
// candidate is found by majority vote (Boyer and Moore 1981) and used if more boxes share it than
// share the coordinate axes.
class SharedAxes {
 public:
  void Add(const Solid& solid) {
    if (solid.form != LaneObstacle::Form::kBox) return;
    if (lead_ == 0) axes_ = solid.X_BS.linear();
    lead_ += Share(axes_, solid) ? 1 : -1;
  }

  Matrix3 Find(std::span<const Solid> solids) const {
    const auto count = [&](const Matrix3& axes) {
      return std::ranges::count_if(solids, [&](const Solid& solid) {
        return solid.form == LaneObstacle::Form::kBox && Share(axes, solid);
      });
    };
    return count(axes_) > count(Matrix3::Identity()) ? axes_ : Matrix3::Identity();
  }

 private:
  static bool Share(const Matrix3& axes, const Solid& solid) {
    const Matrix3 between = axes.transpose() * solid.X_BS.linear();
    return IsAlignedWith(between, 0) && IsAlignedWith(between, 1) && IsAlignedWith(between, 2);
  }

  Matrix3 axes_ = Matrix3::Identity();
  int lead_ = 0;
};

class SceneCompiler {
 public:
  SceneCompiler(const SphereProgram& program, const Pose& X_WB, double max_margin_m)
      : program_(program), X_BW_(X_WB.inverse()), near_(program.lanes.groups.size()) {
    for (const LaneGroup& group : program.lanes.groups) {
      max_bound_radius_m_ = std::max(max_bound_radius_m_, double{group.bound.radius_m});
    }
    reach_m_ = program.lanes.reach_m + max_bound_radius_m_ + max_margin_m;
  }

  double reach_m() const { return reach_m_; }

  // Adds a part of an obstacle for the groups that it is tested with, once for each of their terms.
  void Add(const Obstacle& object, std::size_t index, const LaneTermsOf& terms_of) {
    const PreparedPart& part = object.geometry->parts[index];
    Solid solid = SolidOf(part, X_BW_ * object.parts_W[index].X_WP);
    Clip(reach_m_, solid);
    entries_.clear();
    known_terms_.clear();
    for (std::size_t g = 0; g < near_.size(); ++g) {
      const auto scene_class = static_cast<std::size_t>(program_.class_of_group[g]);
      if (known_terms_.size() <= scene_class) known_terms_.resize(scene_class + 1);
      if (!known_terms_[scene_class]) {
        known_terms_[scene_class] = terms_of(program_.class_of_group[g], object, index);
      }
      const LaneTerms& terms = *known_terms_[scene_class];
      if (!terms.is_tested) continue;
      const SphereProgram::Ball& ball = program_.reach_of_group[g];
      // chosen: a hundredth of a millimetre, far above the single-precision rounding of radii and
      // margins.
      constexpr double kRadiusSlack_m = 1e-5;
      if (Distance_m(solid, ball.centre) > ball.radius_m + terms.margin_m + kRadiusSlack_m) {
        continue;
      }
      near_[g].push_back(EntryOf(solid, terms));
    }
    if (entries_.empty()) return;
    const double out_m = solid.is_bounded
                             ? solid.X_BS.translation().norm() + solid.size_m.cwiseAbs().sum()
                             : reach_m_;
    farthest_m_ = std::max(farthest_m_, out_m);
  }

  LaneScene Take() {
    AddObstacles();
    for (std::size_t g = 0; g < near_.size(); ++g) {
      const LaneGroup& group = program_.lanes.groups[g];
      const auto begin = static_cast<std::int32_t>(scene_.near.size());
      scene_.near.insert(scene_.near.end(), near_[g].begin(), near_[g].end());
      double error_m = 0, motion_error_m = 0, max_radius_m = 0;
      for (std::int32_t c = group.first; c < group.first + group.count; ++c) {
        const LaneCluster& cluster = program_.lanes.clusters[static_cast<std::size_t>(c)];
        error_m = std::max(error_m, double{cluster.centre_error_m});
        motion_error_m = std::max(motion_error_m, double{cluster.motion_error_m});
        max_radius_m = std::max(max_radius_m, double{cluster.max_radius_m});
      }
      const double rounding_m = Rounding_m(reach_m_ + farthest_m_);
      LaneBand band = BandOf(error_m + rounding_m, max_radius_m + max_obstacle_radius_m_,
                             group.bound.radius_m + max_obstacle_radius_m_);
      // derived: between a centre and its distance from the solid, other than relative to it, lie
      // three products and sums, and the rounding of axes, offset and size.
      constexpr double kRoundings = 10 * kFloatRounding;
      constexpr double kAlignment_m = 1e-8;  // of axes that are treated as aligned
      motion_error_m += kRoundings * (reach_m_ + farthest_m_) + kAlignment_m;
      band.motion_error_m = static_cast<float>(1.001 * motion_error_m);
      scene_.near_group.push_back(
          {.begin = begin, .end = static_cast<std::int32_t>(scene_.near.size()), .band = band});
    }
    return std::move(scene_);
  }

 private:
  // The index of the solid with these terms, which is added if it is new.
  std::int32_t EntryOf(const Solid& solid, const LaneTerms& terms) {
    for (const std::int32_t entry : entries_) {
      const auto k = static_cast<std::size_t>(entry);
      const bool is_hull = solid.is_hull || terms.proves_gap_only;
      if (margins_m_[k] == terms.margin_m && solids_[k].is_hull == is_hull) return entry;
    }
    entries_.push_back(static_cast<std::int32_t>(solids_.size()));
    solids_.push_back(solid);
    solids_.back().is_hull = solid.is_hull || terms.proves_gap_only;
    margins_m_.push_back(terms.margin_m);
    // For round obstacles the SIMD check compares the distance from the centre line, which includes
    // the radius.
    const bool is_round = solid.form == LaneObstacle::Form::kRound;
    max_obstacle_radius_m_ =
        std::max(max_obstacle_radius_m_, terms.margin_m + (is_round ? solid.size_m[0] : 0.0));
    return entries_.back();
  }

  void AddObstacles() {
    SharedAxes shared;
    for (const Solid& solid : solids_) shared.Add(solid);
    const Matrix3 axes = shared.Find(solids_);
    for (int i = 0; i < 9; ++i) scene_.rotation[i] = static_cast<float>(axes(i % 3, i / 3));
    for (std::size_t k = 0; k < solids_.size(); ++k) {
      Solid solid = solids_[k];
      solid.X_BS = Pose(axes.transpose()) * solid.X_BS;
      scene_.obstacles.push_back(InLanes(solid, margins_m_[k]));
    }
  }

  const SphereProgram& program_;
  const Pose X_BW_;
  double max_bound_radius_m_ = 0;
  double reach_m_ = 0;                // of spheres with their margins, from the root
  double max_obstacle_radius_m_ = 0;  // largest margin, plus the radius for round obstacles
  double farthest_m_ = 0;             // largest coordinate of an obstacle
  std::vector<Solid> solids_;
  std::vector<double> margins_m_;  // by solid
  // Of the part that is being added: its solids, and its terms by class.
  std::vector<std::int32_t> entries_;
  std::vector<std::optional<LaneTerms>> known_terms_;
  std::vector<std::vector<std::int32_t>> near_;  // indices of near solids, by group
  LaneScene scene_;
};

}  // namespace

LaneScene CompileScene(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double max_margin_m,
                       const LaneTermsOf& terms) {
  SceneCompiler compiler(program, X_WB, max_margin_m);
  const Vector3 reach = Vector3::Constant(compiler.reach_m());
  const Aabb around_W(X_WB.translation() - reach, X_WB.translation() + reach);
  world.bounds().ForEachWithin(around_W, 0, [&](const Obstacle& object) {
    if (filter.Skips(object)) return;
    for (std::size_t k = 0; k < object.parts_W.size(); ++k) {
      if (!filter.SkipsPart(object, k)) compiler.Add(object, k, terms);
    }
  });
  return compiler.Take();
}

namespace {

// The box that the boxes of the robot's parts, with the largest margin, can reach.
Aabb ReachedBox(const SphereProgram& program, const Pose& X_WB, double max_margin_m) {
  // derived: a part lies within its spheres. The bounds of its rotated box exceed them along each
  // axis by a factor of at most sqrt(3).
  constexpr double kBoxOfBox = 2;
  const SceneCompiler compiler(program, X_WB, max_margin_m);
  const Vector3 reach = Vector3::Constant(kBoxOfBox * compiler.reach_m());
  return {X_WB.translation() - reach, X_WB.translation() + reach};
}

}  // namespace

bool ReachesOpenMeshes(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double max_margin_m) {
  bool meets = false;
  world.bounds().ForEachWithin(
      ReachedBox(program, X_WB, max_margin_m), 0, [&](const Obstacle& object) {
        if (filter.Skips(object)) return true;
        const std::vector<PreparedPart>& parts = object.geometry->parts;
        for (std::size_t k = 0; k < parts.size() && !meets; ++k) {
          meets = IsUncertain(parts[k].shape) && !filter.SkipsPart(object, k);
        }
        return !meets;
      });
  return meets;
}

bool ReachesHiddenSpaces(const WorldSnapshot& world, const WorldFilter& filter,
                         const SphereProgram& program, const Pose& X_WB, double max_margin_m) {
  const Aabb reached_W = ReachedBox(program, X_WB, max_margin_m);
  return std::ranges::any_of(HiddenSpacesOf(world, filter), [&](const HiddenSpace& space) {
    return space.bounds_W.intersects(reached_W);
  });
}

LaneScene EmptyScene(const SphereProgram& program) {
  return SceneCompiler(program, Pose::Identity(), 0).Take();
}

}  // namespace cwm::collision
