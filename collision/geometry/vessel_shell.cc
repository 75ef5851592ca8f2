#include "collision/geometry/vessel_shell.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm {
namespace {

// Walks along the profile, from the axis below the foot to the axis on the floor, and keeps the
// nearest distance to the point `query` and on which side of the profile it lies.
struct Walk {
  Vector2 query;
  Vector2 at;
  double nearest_m2 = std::numeric_limits<double>::infinity();
  bool inside = false;

  void To(const Vector2& next) {
    const Vector2 along = next - at;
    const double length_m2 = along.squaredNorm();
    if (length_m2 > 0) {
      const double way = std::clamp((query - at).dot(along) / length_m2, 0.0, 1.0);
      nearest_m2 = std::min(nearest_m2, (query - at - way * along).squaredNorm());
    }
    // Even-odd rule along the horizontal ray outwards. The line that closes the profile lies on the
    // axis, where the ray does not cross it.
    if ((at.y() > query.y()) != (next.y() > query.y()) &&
        query.x() < at.x() + (query.y() - at.y()) / along.y() * along.x()) {
      inside = !inside;
    }
    at = next;
  }
};

}  // namespace

double SignedDistance_m(const VesselShell& shell, const Vector3& p) {
  Walk walk{.query = {p.head<2>().norm(), p.z()}, .at = {0, shell.outer.front().y()}};
  for (const Vector2& point : shell.outer) walk.To(point);
  for (const Vector2& point : shell.inner) walk.To(point);
  return (walk.inside ? -1 : 1) * std::sqrt(walk.nearest_m2);
}

}  // namespace cwm
