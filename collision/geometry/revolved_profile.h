// Convex solids of revolution about z, told by their profile.
#pragma once

#include <span>

#include "collision/geometry/signed_distance.h"

namespace cwm {

// The profile runs through points (radial, z) from the axis at the bottom (first point, radial 0)
// to the axis at the top (last point, radial 0), convex, with the solid on its left. Points may
// coincide.
struct RevolvedSurfacePoint {
  SurfacePoint surface;
  int side = 0;       // nearest side: from profile[side] to profile[side + 1]
  double share = 0;   // of the way along it, in [0, 1]
  Vector2 direction;  // unit, in the xy plane: from the axis to the nearest point
};
RevolvedSurfacePoint NearestOnRevolvedProfile(std::span<const Vector2> profile, const Vector3& p);

}  // namespace cwm
