// What libraries of surfaces and triangles must be told about a solid: whether it holds a point,
// and how far apart two overlapping solids can be pushed at most.
#pragma once

#include <memory>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/kernels/exact.h"

namespace cwm::collision {

// Immutable. Not for half-spaces (they have no bounding box).
class Solid {
 public:
  explicit Solid(std::shared_ptr<const ExactGeometry> exact);

  // Strictly inside; never for an open mesh, which has no inside.
  bool Contains(const Vector3& p) const;

  // A point of each connected part of the shape. Where no surfaces cross, a part lies wholly inside
  // or wholly outside of another solid, so that one point of it decides.
  const std::vector<Vector3>& points() const { return points_; }
  bool is_open() const;
  const ExactGeometry& exact() const { return *exact_; }

 private:
  friend PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b,
                                   const Pose& X_WB);

  std::shared_ptr<const ExactGeometry> exact_;
  std::vector<Vector3> points_;
  Aabb bounds_;
  std::shared_ptr<const ExactGeometry> bounding_box_;
  Pose X_SC_ = Pose::Identity();  // of the bounding box
};

// Whether one solid holds a connected part of the other. Together with "no surfaces cross" this
// decides overlap: a cup inside a closed cupboard touches none of its triangles.
bool OneHoldsPartOfOther(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB);

// For solids that overlap: the least translation that separates their bounding boxes separates them
// too, so the true depth lies between 0 and the one returned. Labelled kBounded with all of it;
// kSurfaceOnly where a mesh is open.
PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB);

}  // namespace cwm::collision
