// The signed distance to solids in their own frames, of one point (N is double) or of several in
// lanes: the formulas that signed_distance.cc and all lanes share. Negative inside.
#if defined(CWM_SOLID_DISTANCE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef CWM_SOLID_DISTANCE_INL_H
#undef CWM_SOLID_DISTANCE_INL_H
#else
#define CWM_SOLID_DISTANCE_INL_H
#endif

#include <limits>
#include <span>

#include "collision/geometry/lane_math-inl.h"
#include "collision/geometry/revolved_profile.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A ball by the offset from its middle, a capsule by that from its core.
template <class N>
HWY_INLINE N DistanceToSphere_m(const Triple<N>& offset, N radius_m) {
  return Sqrt(Dot(offset, offset)) - radius_m;
}

// A point by its heights above faces that stand at right angles, of which the solid lies below all.
template <class N>
struct AboveFaces {
  Triple<N> outside;  // the heights that are positive
  N outside_m;        // their norm
  N highest_m;

  HWY_INLINE N Distance_m() const { return outside_m + Min(highest_m, All<N>(0)); }
};

// The faces of a box; of each pair, the one that is nearer.
template <class N>
HWY_INLINE AboveFaces<N> Above(const Triple<N>& heights) {
  const N zero = All<N>(0);
  const Triple<N> outside{Max(heights.x, zero), Max(heights.y, zero), Max(heights.z, zero)};
  return {outside, Sqrt(Dot(outside, outside)), Max(Max(heights.x, heights.y), heights.z)};
}

template <class N>
HWY_INLINE Triple<N> HeightsOverBox(const Triple<N>& p, const Triple<N>& half_m) {
  return {Abs(p.x) - half_m.x, Abs(p.y) - half_m.y, Abs(p.z) - half_m.z};
}

template <class N>
HWY_INLINE N DistanceToBox_m(const Triple<N>& p, const Triple<N>& half_m) {
  return Above(HeightsOverBox(p, half_m)).Distance_m();
}

// The side and the nearer cap of a cylinder, the border and the nearer face of a plate.
template <class N>
HWY_INLINE AboveFaces<N> Above(N u, N v) {
  const N zero = All<N>(0);
  const Triple<N> outside{Max(u, zero), Max(v, zero), zero};
  const N squared_m2 = outside.x * outside.x + outside.y * outside.y;
  return {outside, Sqrt(squared_m2), Max(u, v)};
}

// Squared, to one side of a plane figure, whose beginning lies (x, y) off; `way`: its share of the
// side to the foot of the point.
template <class N>
HWY_INLINE N SquaredDistanceToSide_m2(N x, N y, N along_x, N along_y, N way) {
  const N share = Min(Max(way, All<N>(0)), All<N>(1));
  const N dx = x - share * along_x, dy = y - share * along_y;
  return dx * dx + dy * dy;
}

// A convex solid of revolution: the nearest of the sides of its profile, or, within all of them,
// the plane that is least deep.
template <class N>
HWY_INLINE N DistanceToRevolved_m(std::span<const ProfileSide> sides, N radial, N z) {
  N highest = All<N>(-std::numeric_limits<double>::infinity());
  N nearest = All<N>(std::numeric_limits<double>::infinity());
  for (const ProfileSide& side : sides) {
    const N along_x = All<N>(side.along.x()), along_y = All<N>(side.along.y());
    const N x = radial - All<N>(side.a.x()), y = z - All<N>(side.a.y());
    const N height = x * All<N>(side.outward.x()) + y * All<N>(side.outward.y());
    highest = Max(highest, height);
    const N way = (x * along_x + y * along_y) / All<N>(side.squared_length_m2);
    nearest = Min(nearest, SquaredDistanceToSide_m2(x, y, along_x, along_y, way));
  }
  return IfThenElse(Le(highest, All<N>(0)), highest, Sqrt(nearest));
}

}  // namespace cwm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
