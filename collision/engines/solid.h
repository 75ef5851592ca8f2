// A solid for libraries of surfaces and triangles: tests containment, and bounds the translation
// that separates two overlapping solids.
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

  // True if `p` is strictly inside. False for an open mesh, which has no inside.
  bool Contains(const Vector3& p) const;

  // One point of each connected part of the shape. If no surfaces cross, a part lies wholly inside
  // or wholly outside another solid, so one point of it decides.
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
  Pose X_SC_ = Pose::Identity();  // the frame of the bounding box, in the shape's frame
};

// True if one solid contains a connected part of the other. Two solids overlap if this holds or if
// their surfaces cross: a cup inside a closed cupboard touches none of its triangles.
bool EitherContainsOther(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB);

// A bound on the depth of two solids that overlap. The minimum translation that separates their
// bounding boxes separates them too, so the true depth lies between 0 and the one returned. The
// result is kBounded with a bound as large as that depth, or kSurfaceOnly if a mesh is open.
PairDistance OverlapBound(const Solid& a, const Pose& X_WA, const Solid& b, const Pose& X_WB);

}  // namespace cwm::collision
