#include <array>
#include <cmath>
#include <utility>

#include "collision/geometry/revolved_profile.h"
#include "collision/kernels/closed_forms.h"

namespace cwm::collision {
namespace {

// Axes at a smaller sine count as parallel: over a length of 10 m they diverge by a hundredth of a
// nanometre.
constexpr double kParallelAxesSine = 1e-12;

// The slanted side of a core's profile, bottom to top, as (radial, z).
struct Side {
  Vector2 bottom, top;
};

Side SideOf(const ConvexCore& shape) {
  if (const auto* segment = std::get_if<SegmentCore>(&shape.core)) {
    return {{0, -segment->half_length_m}, {0, segment->half_length_m}};
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&shape.core)) {
    const double half = 0.5 * cylinder->length_m;
    return {{cylinder->radius_m, -half}, {cylinder->radius_m, half}};
  }
  const Cone& cone = std::get<Cone>(shape.core);
  const double half = 0.5 * cone.length_m;
  return {{cone.radius_bottom_m, -half}, {cone.radius_top_m, half}};
}

Side Mirrored(const Side& side) {
  return {{side.top.x(), -side.top.y()}, {side.bottom.x(), -side.bottom.y()}};
}

// The witness point in A's profile, given the nearest side of the sum's profile.
Vector2 ShareOfA(const Side& a, int side, double share, double radial_share, bool a_first) {
  if (side == 0) return {radial_share * a.bottom.x(), a.bottom.y()};
  if (side == 3) return {radial_share * a.top.x(), a.top.y()};
  const bool on_a = (side == 1) == a_first;
  if (!on_a) return side == 1 ? a.bottom : a.top;
  return a.bottom + share * (a.top - a.bottom);
}

}  // namespace

bool AxesAreParallel(const Pose& X_AB) {
  return X_AB.linear().col(2).head<2>().norm() <= kParallelAxesSine;
}

bool IsRevolved(const ConvexCore& core) {
  return std::holds_alternative<SegmentCore>(core.core) ||
         std::holds_alternative<Cylinder>(core.core) || std::holds_alternative<Cone>(core.core);
}

PairDistance ParallelRevolvedDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB) {
  const Side side_a = SideOf(a);
  // A - B contains B mirrored at its centre; an axis of B that points down mirrors it back.
  const Side side_b = X_AB.linear()(2, 2) > 0 ? Mirrored(SideOf(b)) : SideOf(b);
  const Vector2 along_a = side_a.top - side_a.bottom, along_b = side_b.top - side_b.bottom;
  // Both sides rise; in a convex chain the one that leans outward more comes first.
  const bool a_first = along_a.x() * along_b.y() >= along_b.x() * along_a.y();
  const Vector2 bottom = side_a.bottom + side_b.bottom, top = side_a.top + side_b.top;
  const Vector2 knee = bottom + (a_first ? along_a : along_b);
  const std::array<Vector2, 5> profile = {Vector2(0, bottom.y()), bottom, knee, top,
                                          Vector2(0, top.y())};
  const RevolvedSurfacePoint at = NearestOnRevolvedProfile(profile, X_AB.translation());
  const double rim = at.side == 0 ? bottom.x() : top.x();
  const double radial_share = rim > 0 ? at.surface.nearest.head<2>().norm() / rim : 0;
  const Vector2 on_a = ShareOfA(side_a, at.side, at.share, radial_share, a_first);
  PairDistance cores{.distance_m = at.surface.signed_distance_m, .normal = at.surface.normal};
  cores.point_a = Vector3(on_a.x() * at.direction.x(), on_a.x() * at.direction.y(), on_a.y());
  cores.point_b = cores.point_a + cores.distance_m * cores.normal;
  return WithRadii(cores, a.radius_m, b.radius_m);
}

}  // namespace cwm::collision
