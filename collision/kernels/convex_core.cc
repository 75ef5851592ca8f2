#include "collision/kernels/convex_core.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace cwm::collision {
namespace {

struct CoreOfShape {
  ConvexCore operator()(const Sphere& s) const { return {PointCore{}, s.radius_m}; }
  ConvexCore operator()(const Box& s) const {
    return {s, 0, Vector3::Zero(), 0.5 * s.size_m.norm()};
  }
  ConvexCore operator()(const Cylinder& s) const {
    return {s, 0, Vector3::Zero(), std::hypot(s.radius_m, 0.5 * s.length_m)};
  }
  ConvexCore operator()(const Cone& s) const {
    const double radius = std::max(s.radius_bottom_m, s.radius_top_m);
    return {s, 0, Vector3::Zero(), std::hypot(radius, 0.5 * s.length_m)};
  }
  ConvexCore operator()(const Capsule& s) const {
    return {SegmentCore{0.5 * s.length_m}, s.radius_m, Vector3::Zero(), 0.5 * s.length_m};
  }
  ConvexCore operator()(const Convex& s) const { return CoreOf(std::span(s.hull->vertices)); }
  template <class Unbounded>
  ConvexCore operator()(const Unbounded&) const {
    assert(false && "not a bounded convex shape");
    return {PointCore{}};
  }
};

}  // namespace

ConvexCore CoreOf(const Shape& shape) { return std::visit(CoreOfShape{}, shape); }

ConvexCore CoreOf(std::span<const Vector3> vertices) {
  // The mean of the corners lies inside the hull.
  Vector3 centre = Vector3::Zero();
  for (const Vector3& v : vertices) centre += v / static_cast<double>(vertices.size());
  double extent_squared = 0;
  for (const Vector3& v : vertices) {
    extent_squared = std::max(extent_squared, (v - centre).squaredNorm());
  }
  return {VertexCore{vertices}, 0, centre, std::sqrt(extent_squared)};
}

}  // namespace cwm::collision
