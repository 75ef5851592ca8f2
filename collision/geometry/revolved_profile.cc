#include "collision/geometry/revolved_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm {
namespace {

// Share of the shape's size. Nearer to a sharp edge than this, the direction away from the edge is
// lost in the rounding of poses (2^-52 of coordinates that may be thousands of sizes), and a face's
// normal is used instead.
constexpr double kProfileRoundoff = 1e-11;

// The nearest point on the sides that were tried so far.
struct Nearest {
  void Try(const ProfileSide& side, int index, const Vector2& p) {
    const double height = (p - side.b).dot(side.outward);
    inside = inside && height <= 0;
    const double way = std::clamp((p - side.a).dot(side.along) / side.squared_length_m2, 0.0, 1.0);
    const Vector2 on_side = way < 1 ? Vector2(side.a + way * side.along) : side.b;
    const double to_side = (p - on_side).squaredNorm();
    if (to_side >= squared_m2) return;
    squared_m2 = to_side;
    nearest = on_side;
    outward = side.outward;
    side_index = index;
    share = way;
    plane_distance_m = height;
  }
  double Distance_m() const { return std::sqrt(squared_m2); }
  double SignedDistance_m() const { return inside ? plane_distance_m : Distance_m(); }

  double squared_m2 = std::numeric_limits<double>::infinity();
  Vector2 nearest = Vector2::Zero();
  Vector2 outward = Vector2::UnitY();
  int side_index = 0;
  double share = 0;
  double plane_distance_m = 0;  // signed height over the side that holds the nearest point
  bool inside = true;           // true if the point lies behind all sides tried
};

}  // namespace

std::array<Vector2, 4> ProfileOf(const Cone& cone) {
  const double half = 0.5 * cone.length_m;
  return {Vector2(0, -half), Vector2(cone.radius_bottom_m, -half), Vector2(cone.radius_top_m, half),
          Vector2(0, half)};
}

std::array<Vector2, 4> ProfileOf(const Cylinder& cylinder) {
  return ProfileOf(Cone{cylinder.radius_m, cylinder.radius_m, cylinder.length_m});
}

std::optional<ProfileSide> ProfileSide::Between(const Vector2& a, const Vector2& b) {
  const Vector2 along = b - a;
  const double length = along.norm();
  if (!(length > 0)) return std::nullopt;
  return ProfileSide{.a = a,
                     .b = b,
                     .along = along,
                     .outward = Vector2(along.y() / length, -along.x() / length),
                     .squared_length_m2 = length * length};
}

RevolvedSurfacePoint NearestOnRevolvedProfile(std::span<const Vector2> profile, const Vector3& p) {
  const double radial = p.head<2>().norm();
  // On the axis every direction is valid.
  const Vector2 direction = radial > 0 ? Vector2(p.head<2>() / radial) : Vector2::UnitX();
  const Vector2 query(radial, p.z());
  Nearest at;
  at.nearest = query;
  double size = 0;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    size = std::max(size, profile[i + 1].cwiseAbs().maxCoeff());
    const std::optional<ProfileSide> side = ProfileSide::Between(profile[i], profile[i + 1]);
    if (side) at.Try(*side, static_cast<int>(i), query);
  }
  const double distance_m = at.Distance_m();
  const bool away = !at.inside && distance_m > kProfileRoundoff * size;
  const Vector2 normal = away ? Vector2((query - at.nearest) / distance_m) : at.outward;
  const auto lift = [&direction](const Vector2& v) {
    return Vector3(v.x() * direction.x(), v.x() * direction.y(), v.y());
  };
  return {{at.SignedDistance_m(), lift(at.nearest), lift(normal).normalized()},
          at.side_index,
          at.share,
          direction};
}

DistanceToRevolvedProfile::DistanceToRevolvedProfile(std::span<const Vector2> profile) {
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const std::optional<ProfileSide> side = ProfileSide::Between(profile[i], profile[i + 1]);
    if (side) sides_.push_back(*side);
  }
}

double DistanceToRevolvedProfile::operator()(const Vector3& p) const {
  const Vector2 query(p.head<2>().norm(), p.z());
  Nearest at;
  for (const ProfileSide& side : sides_) at.Try(side, 0, query);
  return at.SignedDistance_m();
}

}  // namespace cwm
