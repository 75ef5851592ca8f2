#include "perception/hypotheses/complete_hidden.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/tolerances.h"
#include "perception/fit/solid.h"
#include "perception/search/model_points.h"
#include "perception/segmentation/surface_graph.h"
#include "perception/solids/extended_solid.h"

namespace cwm::perception {
namespace {

// chosen: the distance between tested places on the added wall, two or three pixels. Places that
// face away from the sensor are moved inwards by as much, less than half of the narrowest solid.
constexpr double kBetweenPlaces_m = 0.01;
// chosen: the largest share of all tested places that are seen through. Mixed pixels and the width
// of the map's cells at the occluder's edge make as much.
constexpr double kMaxSeenThrough = 0.03;
// chosen: the largest share of the places facing the sensor at which a surface was seen. If there
// are more, nothing hides the wall.
constexpr double kMaxSeen = 0.15;

// An upright solid in its own frame: its vertical axis, and half its extent along it.
struct Upright {
  Eigen::Index axis = 2;
  double sign = 1;  // +1: the axis points up
  double half_length_m = 0;
};

std::optional<Upright> UprightOf(const ShapePart& part, const Vector3& up_L) {
  const Vector3 up_S = part.X_OS.linear().transpose() * up_L;
  Upright upright;
  if (std::holds_alternative<Box>(part.shape)) up_S.cwiseAbs().maxCoeff(&upright.axis);
  upright.half_length_m = 0.5 * LengthAlong_m(part.shape, upright.axis).value_or(0);
  if (std::abs(up_S[upright.axis]) < std::cos(kSameDirection_rad)) return std::nullopt;
  upright.sign = up_S[upright.axis] > 0 ? 1 : -1;
  if (!(upright.half_length_m > 0)) return std::nullopt;
  return upright;
}

// The solid extended by `gap_m` at its lower end; empty if it would end in an apex before.
std::optional<ShapePart> ExtendedBelow(const ShapePart& part, const Upright& upright,
                                       double gap_m) {
  const SolidEnd lower{upright.axis, -upright.sign};
  if (!(gap_m < MaxExtension_m(part.shape, lower))) return std::nullopt;
  Placed<> placed = Extended({part.X_OS, part.shape}, lower, gap_m);
  ShapePart longer = part;
  longer.X_OS = placed.X_FS;
  longer.shape = std::move(placed.shape);
  if (std::holds_alternative<Box>(part.shape) && longer.fit &&
      !longer.fit->parameter_sigma.empty()) {
    longer.fit->parameter_sigma[static_cast<std::size_t>(upright.axis)] = 0;  // not seen
  }
  return longer;
}

// Half the width in a direction normal to the axis, at a height along the axis.
struct Width {
  Eigen::Index axis = 2;
  double along_m = 0;
  Vector3 direction_S = Vector3::UnitX();
  double operator()(const Box& box) const {
    double reach_m = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (k == axis || direction_S[k] == 0) continue;
      reach_m = std::min(reach_m, 0.5 * box.size_m[k] / std::abs(direction_S[k]));
    }
    return reach_m;
  }
  double operator()(const Cylinder& c) const { return c.radius_m; }
  double operator()(const Cone& c) const {
    return std::lerp(c.radius_bottom_m, c.radius_top_m, 0.5 + along_m / c.length_m);
  }
  template <class Other>
  double operator()(const Other&) const {
    return 0;
  }
};

// The outward normal, across the axis, at the place in a direction.
struct Outward {
  Eigen::Index axis = 2;
  Vector3 direction_S = Vector3::UnitX();
  Vector3 operator()(const Box& box) const {
    Eigen::Index nearest = axis;
    double reach_m = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (k == axis || direction_S[k] == 0) continue;
      const double here_m = 0.5 * box.size_m[k] / std::abs(direction_S[k]);
      if (here_m < reach_m) reach_m = here_m, nearest = k;
    }
    Vector3 normal = Vector3::Zero();
    normal[nearest] = direction_S[nearest] > 0 ? 1 : -1;
    return normal;
  }
  template <class Other>
  Vector3 operator()(const Other&) const {
    return direction_S;
  }
};

// The visibility of the added wall. Of a wall that faces away, the places just inside it count.
struct Seen {
  int facing = 0, on_surface = 0;
  int places = 0, passed = 0;  // facing the sensor or not
};

Seen VisibilityOfAddedWall(const ShapePart& longer, const Upright& upright, double gap_m,
                           const SightMap& sight, double tolerance_m) {
  Seen seen;
  const Eigen::Index across = (upright.axis + 1) % 3, beside = (upright.axis + 2) % 3;
  const Vector3 viewpoint_S =
      longer.X_OS.inverse(Eigen::Isometry) * sight.viewpoint().cast<double>();
  const double bottom_m = -upright.sign * (upright.half_length_m + 0.5 * gap_m);
  const int rings = std::max(1, static_cast<int>(gap_m / kBetweenPlaces_m));
  for (int ring = 0; ring < rings; ++ring) {
    const double along_m = bottom_m + upright.sign * gap_m * (ring + 0.5) / rings;
    for (int k = 0; k < kSectors; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / kSectors;
      Vector3 direction = Vector3::Zero();
      direction[across] = std::cos(angle_rad);
      direction[beside] = std::sin(angle_rad);
      Vector3 place = std::visit(Width{upright.axis, along_m, direction}, longer.shape) * direction;
      place[upright.axis] = along_m;
      const Vector3 normal = std::visit(Outward{upright.axis, direction}, longer.shape);
      // Places that face away are too near to the wall's outline to be distinguished from its
      // surroundings.
      const bool faces = normal.dot((viewpoint_S - place).normalized()) >= kGrazing_sin;
      if (!faces) place -= kBetweenPlaces_m * normal;
      const Visibility visibility =
          sight.VisibilityAt((longer.X_OS * place).cast<float>(), static_cast<float>(tolerance_m));
      ++seen.places;
      seen.passed += visibility == Visibility::kSeenThrough;
      if (!faces) continue;
      ++seen.facing;
      seen.on_surface += visibility == Visibility::kOnSurface;
    }
  }
  return seen;
}

bool IsHidden(const Seen& seen) {
  return seen.passed <= kMaxSeenThrough * seen.places && seen.on_surface <= kMaxSeen * seen.facing;
}

// The height, in metres, of the lower end of an upright solid that no point lies on.
double UnseenFoot_m(const StandingObject& object, const ShapePart& part) {
  const Pose X_SL = part.X_OS.inverse(Eigen::Isometry);
  const Pose X_SupportL = object.X_LSupport.inverse(Eigen::Isometry);
  std::vector<double> heights_m;
  for (std::size_t i = 0; i < object.points.size(); ++i) {
    const Vector3 p = object.points.points[i].cast<double>();
    const double gate_m = kDistanceGate_sigma * object.points.sigma_m[i];
    if (std::abs(SignedDistance_m(part.shape, X_SL * p)) > gate_m) continue;
    heights_m.push_back((X_SupportL * p).z());
  }
  return heights_m.empty() ? 0 : Quantile(heights_m, kMixedPixels);
}

// True if the object has points below the solid that are not on the added wall: another part of it
// is there.
bool IsVisibleBelow(const StandingObject& object, const ShapePart& part, const ShapePart& longer,
                    const Upright& upright, double gap_m) {
  const Pose X_SL = part.X_OS.inverse(Eigen::Isometry);
  const Pose X_LongerL = longer.X_OS.inverse(Eigen::Isometry);
  Aabb below = TightBounds(part.shape, Pose::Identity());
  const double bottom_m = -upright.sign * upright.half_length_m;
  below.min()[upright.axis] = std::min(bottom_m, bottom_m - upright.sign * gap_m);
  below.max()[upright.axis] = std::max(bottom_m, bottom_m - upright.sign * gap_m);
  std::size_t count = 0;
  for (std::size_t i = 0; i < object.points.size() && count <= kOneSample; ++i) {
    const double gate_m = MaxJump_m(object.points.sigma_m[i]);
    Aabb wide = below;
    wide.min().array() -= gate_m;
    wide.max().array() += gate_m;
    // Points count from a distance below the solid's lower end that is clear of the noise.
    (upright.sign > 0 ? wide.max() : wide.min())[upright.axis] = bottom_m - upright.sign * gate_m;
    const Vector3 p = object.points.points[i].cast<double>();
    count +=
        wide.contains(X_SL * p) && std::abs(SignedDistance_m(longer.shape, X_LongerL * p)) > gate_m;
  }
  return count > kOneSample;
}

double SurfaceArea_m2(const Shape& shape) {
  if (const auto* box = std::get_if<Box>(&shape)) {
    const Vector3& s = box->size_m;
    return 2 * (s.x() * s.y() + s.y() * s.z() + s.z() * s.x());
  }
  double bottom_m = 0, top_m = 0, length_m = 0;
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    bottom_m = top_m = cylinder->radius_m, length_m = cylinder->length_m;
  } else if (const auto* cone = std::get_if<Cone>(&shape)) {
    bottom_m = cone->radius_bottom_m, top_m = cone->radius_top_m, length_m = cone->length_m;
  }
  return std::numbers::pi * (bottom_m * bottom_m + top_m * top_m +
                             (bottom_m + top_m) * std::hypot(length_m, top_m - bottom_m));
}

double HeightOfLowest_m(const ShapePart& part, const Pose& X_LSupport) {
  return TightBounds(part.shape, X_LSupport.inverse(Eigen::Isometry) * part.X_OS).min().z();
}

}  // namespace

void CompleteHidden(const StandingObject& object, const SightMap& sight,
                    std::vector<ShapePart>& shapes) {
  if (object.points.points.empty()) return;
  const double tolerance_m = MaxJump_m(Median(object.points.sigma_m));
  const Vector3 up_L = object.X_LSupport.linear().col(2);
  for (ShapePart& part : shapes) {
    const std::optional<Upright> upright = UprightOf(part, up_L);
    if (!upright) continue;
    const double gap_m = HeightOfLowest_m(part, object.X_LSupport);
    if (gap_m < -kGroundNoise_m) continue;
    if (gap_m < kGroundNoise_m) {
      // The fit reaches the ground already; it is completed if its foot is hidden.
      const double unseen_m = UnseenFoot_m(object, part);
      if (unseen_m < kStandingGap_m) continue;
      Upright seen_part = *upright;
      seen_part.half_length_m -= 0.5 * unseen_m;
      if (IsHidden(VisibilityOfAddedWall(part, seen_part, unseen_m, sight, tolerance_m))) {
        part.role = PartRole::kCompleted;
      }
      continue;
    }
    std::optional<ShapePart> longer = ExtendedBelow(part, *upright, gap_m);
    if (!longer || IsVisibleBelow(object, part, *longer, *upright, gap_m)) continue;
    if (!IsHidden(VisibilityOfAddedWall(*longer, *upright, gap_m, sight, tolerance_m))) continue;
    longer->role = PartRole::kCompleted;
    if (longer->fit) {
      longer->fit->observed_fraction *= SurfaceArea_m2(part.shape) / SurfaceArea_m2(longer->shape);
    }
    part = *std::move(longer);
  }
}

}  // namespace cwm::perception
