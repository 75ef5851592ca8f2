// What libraries of surfaces and triangles must be told about a solid: whether it holds a point,
// and how far apart two overlapping solids can be pushed at most.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision/engines/closed_mesh.h"
#include "collision/geometry/aabb.h"
#include "collision/kernels/exact.h"

namespace cwm::collision {

// Immutable. Not for half-spaces (they have no bounding box).
class Solid {
 public:
  explicit Solid(const Shape& shape);

  // Strictly inside; never for an open mesh, which has no inside.
  bool Contains(const Vector3& p) const;

  // A point of each connected part of the shape.
  const std::vector<Vector3>& points() const { return points_; }
  bool is_open() const { return is_open_; }
  const Aabb& bounds() const { return bounds_; }

 private:
  friend PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b,
                                   const Pose& X_WB);

  Shape shape_;
  bool is_open_ = false;
  std::optional<ClosedMesh> closed_mesh_;
  std::vector<Vector3> points_;
  Aabb bounds_;
  std::shared_ptr<const ExactGeometry> bounding_box_;
  Pose X_SC_ = Pose::Identity();  // of the bounding box
};

// Whether one solid holds a connected part of the other. Together with "no surfaces cross" this
// decides overlap.
bool OneHoldsPartOfOther(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB);

// For solids that overlap: the least translation that separates their bounding boxes separates them
// too, so the true depth lies between 0 and the one returned. Labelled kBounded with all of it.
PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB);

}  // namespace cwm::collision
