// Every bounded convex shape is a core with a ball of some radius rolled around it. Distances of
// the cores less the radii are distances of the shapes, separated or not, so that GJK and EPA only
// ever see cores.
#pragma once

#include <span>
#include <variant>

#include "collision/geometry/shape.h"
#include "collision/geometry/support.h"

namespace cwm::collision {

struct PointCore {};  // the origin
struct SegmentCore {  // on z, centred
  double half_length_m = 0;
};
struct VertexCore {  // the hull of at least one vertex; owned by somebody who lives longer
  std::span<const Vector3> vertices;
};

struct ConvexCore {
  std::variant<PointCore, SegmentCore, VertexCore, Box, Cylinder, Cone> core;
  double radius_m = 0;
  Vector3 centre = Vector3::Zero();  // some point inside of the core
  double extent_m = 0;               // no point of the core is farther from `centre`
};

// Precondition: IsConvex(kind) and not a half-space. Refers to the vertices of a hull.
ConvexCore CoreOf(const Shape& shape);
ConvexCore CoreOf(std::span<const Vector3> vertices);

inline Vector3 SupportPoint(const ConvexCore& shape, const Vector3& d) {
  switch (shape.core.index()) {
    case 0:
      return Vector3::Zero();
    case 1:
      return {0, 0, std::copysign(std::get_if<1>(&shape.core)->half_length_m, d.z())};
    case 2:
      return cwm::SupportPoint(std::get_if<2>(&shape.core)->vertices, d);
    case 3:
      return cwm::SupportPoint(*std::get_if<3>(&shape.core), d);
    case 4:
      return cwm::SupportPoint(*std::get_if<4>(&shape.core), d);
    default:
      return cwm::SupportPoint(*std::get_if<5>(&shape.core), d);
  }
}

// Two cores in the frame of A, as their difference D = A - B sees them: D contains the origin
// exactly when the cores meet, and its point nearest to the origin tells their distance.
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

  // D after B has moved by `offset`, in the frame of A.
  CoreDifference Moved(const Vector3& offset) const {
    CoreDifference moved = *this;
    moved.p_AB_ += offset;
    return moved;
  }

  // From inside of B to inside of A.
  Vector3 CentreOffset() const { return a_.centre - (R_AB_ * b_.centre + p_AB_); }

  // No point of D is farther from CentreOffset().
  double extent_m() const { return a_.extent_m + b_.extent_m; }

 private:
  const ConvexCore& a_;
  const ConvexCore& b_;
  Matrix3 R_AB_;
  Vector3 p_AB_;
};

}  // namespace cwm::collision
