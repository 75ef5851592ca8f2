#include "collision/geometry/revolved_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm {
namespace {

// Nearer to a sharp edge than this share of the shape's size, the direction away from it is lost in
// the rounding of poses (2^-52 of coordinates that may be thousands of sizes) and a face's normal
// is used instead.
constexpr double kRoundoff = 1e-11;

struct ProfilePoint {
  double signed_distance_m;
  Vector2 nearest;
  Vector2 normal;
  int side;
  double share;
};

ProfilePoint NearestOnProfile(std::span<const Vector2> profile, const Vector2& p) {
  ProfilePoint best{std::numeric_limits<double>::infinity(), p, Vector2::UnitY(), 0, 0};
  double size = 0;
  double plane_distance = 0;  // to the side that holds the best point
  bool inside = true;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const Vector2 &a = profile[i], &b = profile[i + 1];
    size = std::max(size, b.cwiseAbs().maxCoeff());
    const Vector2 along = b - a;
    const double length = along.norm();
    if (!(length > 0)) continue;
    const Vector2 outward(along.y() / length, -along.x() / length);
    const double height = (p - b).dot(outward);
    inside = inside && height <= 0;
    const double share = std::clamp((p - a).dot(along) / (length * length), 0.0, 1.0);
    const Vector2 nearest = share < 1 ? Vector2(a + share * along) : b;
    const double distance = (p - nearest).norm();
    if (distance >= best.signed_distance_m) continue;
    best = {distance, nearest, outward, static_cast<int>(i), share};
    plane_distance = height;
  }
  if (inside) {
    best.signed_distance_m = plane_distance;
  } else if (best.signed_distance_m > kRoundoff * size) {
    best.normal = (p - best.nearest) / best.signed_distance_m;
  }
  return best;
}

}  // namespace

RevolvedSurfacePoint NearestOnRevolvedProfile(std::span<const Vector2> profile, const Vector3& p) {
  const double radial = p.head<2>().norm();
  // On the axis every direction is valid.
  const Vector2 direction = radial > 0 ? Vector2(p.head<2>() / radial) : Vector2::UnitX();
  const ProfilePoint at = NearestOnProfile(profile, Vector2(radial, p.z()));
  const auto lift = [&direction](const Vector2& v) {
    return Vector3(v.x() * direction.x(), v.x() * direction.y(), v.y());
  };
  return {{at.signed_distance_m, lift(at.nearest), lift(at.normal).normalized()},
          at.side,
          at.share,
          direction};
}

}  // namespace cwm
