// Every bounded convex shape is the Minkowski sum of a core and a ball. The distance of two shapes
// is that of their cores minus the radii, separated or not, so GJK and EPA only handle cores.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <variant>

#include "collision/geometry/shape.h"
#include "collision/geometry/support.h"
#include "collision/kernels/vertex_lanes.h"

namespace cwm::collision {

struct PointCore {};  // the origin
struct SegmentCore {  // on z, centred
  double half_length_m = 0;
};
struct VertexCore {  // the hull of at least one vertex; the owner must outlive it
  std::span<const Vector3> vertices;
  const VertexLanes* lanes = nullptr;  // the same vertices, if they are many
};

struct ConvexCore {
  std::variant<PointCore, SegmentCore, VertexCore, Box, Cylinder, Cone> core;
  double radius_m = 0;
  Vector3 centre = Vector3::Zero();  // a point inside the core
  double extent_m = 0;               // no point of the core is farther from `centre`
};

// The core of a shape. Precondition: IsConvex(kind) and not a half-space. Refers to the vertices of
// a hull.
ConvexCore CoreOf(const Shape& shape);
ConvexCore CoreOf(std::span<const Vector3> vertices);

inline Vector3 SupportPoint(const VertexCore& hull, const Vector3& d) {
  return hull.lanes != nullptr ? hull.vertices[hull.lanes->Farthest(d)]
                               : cwm::SupportPoint(hull.vertices, d);
}

inline Vector3 SupportPoint(const ConvexCore& shape, const Vector3& d) {
  switch (shape.core.index()) {
    case 0:
      return Vector3::Zero();
    case 1:
      return {0, 0, std::copysign(std::get_if<1>(&shape.core)->half_length_m, d.z())};
    case 2:
      return SupportPoint(*std::get_if<2>(&shape.core), d);
    case 3:
      return cwm::SupportPoint(*std::get_if<3>(&shape.core), d);
    case 4:
      return cwm::SupportPoint(*std::get_if<4>(&shape.core), d);
    default:
      return cwm::SupportPoint(*std::get_if<5>(&shape.core), d);
  }
}

// The point of a core nearest to `p`, if clamping coordinates finds it (box, segment, cylinder);
// else the core's centre.
inline Vector3 ClampToCore(const ConvexCore& shape, const Vector3& p) {
  if (const auto* box = std::get_if<Box>(&shape.core)) {
    const Vector3 half = 0.5 * box->size_m;
    return p.cwiseMax(-half).cwiseMin(half);
  }
  if (const auto* segment = std::get_if<SegmentCore>(&shape.core)) {
    return {0, 0, std::clamp(p.z(), -segment->half_length_m, segment->half_length_m)};
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&shape.core)) {
    const double half = 0.5 * cylinder->length_m, beside = p.head<2>().norm();
    const double scale = beside > cylinder->radius_m ? cylinder->radius_m / beside : 1;
    return {scale * p.x(), scale * p.y(), std::clamp(p.z(), -half, half)};
  }
  return shape.centre;
}

// The Minkowski difference D = A - B of two cores in the frame of A. D contains the origin exactly
// if the cores meet; else its point nearest to the origin gives their distance.
class CoreDifference {
 public:
  CoreDifference(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB)
      : a_(a), b_(b), R_AB_(X_AB.linear()), p_AB_(X_AB.translation()) {}

  struct Vertex {
    Vector3 w;  // a - b
    Vector3 a;
  };

  // The vertex of D farthest along `d`.
  Vertex Support(const Vector3& d) const {
    const Vector3 a = SupportPoint(a_, d);
    const Vector3 b = R_AB_ * SupportPoint(b_, -(R_AB_.transpose() * d)) + p_AB_;
    return {a - b, a};
  }

  // D after moving B by `offset`, in the frame of A.
  CoreDifference Moved(const Vector3& offset) const {
    CoreDifference moved = *this;
    moved.p_AB_ += offset;
    return moved;
  }

  // The vector from a point inside B to a point inside A.
  Vector3 CentreOffset() const { return a_.centre - (R_AB_ * b_.centre + p_AB_); }

  // The vector from a point of B to a point of A that ClampToCore finds near each other. Only a
  // start for searches; zero if that point of B lies in A.
  Vector3 NearOffset() const;

  // No point of D is farther from CentreOffset().
  double extent_m() const { return a_.extent_m + b_.extent_m; }

 private:
  const ConvexCore& a_;
  const ConvexCore& b_;
  Matrix3 R_AB_;
  Vector3 p_AB_;
};

inline Vector3 CoreDifference::NearOffset() const {
  const Vector3 centre_B = R_AB_.transpose() * (a_.centre - p_AB_);
  const Vector3 on_b = R_AB_ * ClampToCore(b_, centre_B) + p_AB_;
  return ClampToCore(a_, on_b) - on_b;
}

}  // namespace cwm::collision
