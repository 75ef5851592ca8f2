#include "collision/geometry/aabb.h"

#include <cmath>
#include <limits>

namespace cwm {
namespace {

// Components of a half-space's normal below this count as zero. derived: over kMaxCoordinate_m
// the plane then deviates from the axis-aligned one by at most a nanometre.
constexpr double kAxisTolerance = 1e-15;

Aabb AroundCentre(const Vector3& centre, const Vector3& reach) {
  return {centre - reach, centre + reach};
}

// The extent of a disc of unit radius along each axis of F: the length of that axis' projection
// onto the plane of the disc.
Vector3 ReachOfUnitDisc(const Pose& X_FS) { return X_FS.linear().leftCols<2>().rowwise().norm(); }

Aabb AroundDisc(const Pose& X_FS, double radius, double z) {
  return AroundCentre(X_FS * Vector3(0, 0, z), radius * ReachOfUnitDisc(X_FS));
}

Aabb AroundPoints(const std::vector<Vector3>& points, const Pose& X_FS) {
  Aabb bounds;
  for (const Vector3& p : points) bounds.extend(X_FS * p);
  return bounds;
}

struct TightBoundsOf {
  const Pose& X_FS;

  Aabb operator()(const Sphere& s) const {
    return AroundCentre(X_FS.translation(), Vector3::Constant(s.radius_m));
  }
  Aabb operator()(const Box& s) const {
    return AroundCentre(X_FS.translation(), X_FS.linear().cwiseAbs() * (0.5 * s.size_m));
  }
  Aabb operator()(const Cylinder& s) const {
    return (*this)(Cone{s.radius_m, s.radius_m, s.length_m});
  }
  Aabb operator()(const Cone& s) const {
    return AroundDisc(X_FS, s.radius_bottom_m, -0.5 * s.length_m)
        .merged(AroundDisc(X_FS, s.radius_top_m, 0.5 * s.length_m));
  }
  Aabb operator()(const Capsule& s) const {
    const Vector3 reach = (0.5 * s.length_m * X_FS.linear().col(2)).cwiseAbs();
    return AroundCentre(X_FS.translation(), reach + Vector3::Constant(s.radius_m));
  }
  Aabb operator()(const HalfSpace&) const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Aabb bounds(Vector3::Constant(-kInfinity), Vector3::Constant(kInfinity));
    const Vector3 normal = X_FS.linear().col(2);
    for (int i = 0; i < 3; ++i) {
      const double others = std::max(std::abs(normal[(i + 1) % 3]), std::abs(normal[(i + 2) % 3]));
      if (others > kAxisTolerance) continue;
      (normal[i] > 0 ? bounds.max() : bounds.min())[i] = X_FS.translation()[i];
    }
    return bounds;
  }
  Aabb operator()(const Plate& s) const {
    Aabb bounds;
    for (const Vector2& p : s.outline) {
      bounds.extend(X_FS * Vector3(p.x(), p.y(), 0));
      bounds.extend(X_FS * Vector3(p.x(), p.y(), -s.thickness_m));
    }
    return bounds;
  }
  Aabb operator()(const Convex& s) const { return AroundPoints(s.hull->vertices, X_FS); }
  Aabb operator()(const Mesh& s) const {
    Aabb bounds;  // over the triangles, since a vertex without a triangle is not part of the solid
    for (const TriangleMesh::Triangle& t : s.mesh->triangles) {
      for (const std::uint32_t i : t) bounds.extend(X_FS * s.mesh->vertices[i]);
    }
    return bounds;
  }
};

}  // namespace

Aabb TightBounds(const Shape& shape, const Pose& X_FS) {
  return std::visit(TightBoundsOf{X_FS}, shape);
}

}  // namespace cwm
