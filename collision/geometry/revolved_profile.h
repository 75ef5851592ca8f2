// Convex solids of revolution about z, described by their profile.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/signed_distance.h"

namespace cwm {

std::array<Vector2, 4> ProfileOf(const Cone& cone);
std::array<Vector2, 4> ProfileOf(const Cylinder& cylinder);

// The profile runs through points (radial, z) from the axis at the bottom (first point, radial 0)
// to the axis at the top (last point, radial 0), convex, with the solid on its left. Points may
// coincide.
struct RevolvedSurfacePoint {
  SurfacePoint surface;
  int side = 0;       // nearest side: from profile[side] to profile[side + 1]
  double share = 0;   // position along that side, in [0, 1]
  Vector2 direction;  // unit, in the xy plane: from the axis to the nearest point
};
RevolvedSurfacePoint NearestOnRevolvedProfile(std::span<const Vector2> profile, const Vector3& p);

// One side of a profile, with the values that do not depend on the query point.
struct ProfileSide {
  // The side from a to b; empty if they coincide.
  static std::optional<ProfileSide> Between(const Vector2& a, const Vector2& b);

  Vector2 a, b;
  Vector2 along;    // b - a
  Vector2 outward;  // unit
  double squared_length_m2 = 0;
};

// The signed distance of many points to one profile: the same bits as NearestOnRevolvedProfile.
class DistanceToRevolvedProfile {
 public:
  explicit DistanceToRevolvedProfile(std::span<const Vector2> profile);
  double operator()(const Vector3& p) const;  // metres, negative inside

 private:
  std::vector<ProfileSide> sides_;
};

}  // namespace cwm
