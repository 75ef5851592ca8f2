// The exact kernels as an engine.
#pragma once

#include <optional>

#include "collision/engines/engine.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/mesh_caps.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

class ExactEngine final : public Engine {
 public:
  EngineKind kind() const override { return EngineKind::kExact; }
  bool Supports(ShapeKind a, ShapeKind b, QueryKind query) const override;  // always true
  std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const override;
  bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                WorkCounter* work = nullptr) const override;
  PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        WorkCounter* work = nullptr) const override;
  // Appends as many contacts as kernels/contact_patch.h finds.
  void Contacts(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                int max_count, std::vector<PairDistance>& contacts,
                WorkCounter* work = nullptr) const override;
};

// The first hit of a ray with a geometry that ExactEngine prepared, in the frame of X_WS.
std::optional<RayHit> CastRay(const EngineGeometry& exact, const Pose& X_WS, const Ray& ray,
                              WorkCounter* work = nullptr);

// ExactDistanceWithin of two geometries that ExactEngine prepared.
PairDistance DistanceWithin(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                            double slack, WorkCounter* work = nullptr);

// ExactLowerBound_m of two geometries that ExactEngine prepared.
std::optional<double> LowerBound_m(const PlacedGeometry& a, const PlacedGeometry& b);

// The error of answers near closed holes of meshes (kernels/mesh_caps.h), for geometries that
// ExactEngine prepared: of a pair, of a point in the shape's frame, and whether a ray's hit may be
// another.
CapError CapErrorOf(const PlacedGeometry& a, const PlacedGeometry& b, double reach_m,
                    WorkCounter* work = nullptr);
CapError CapErrorAt(const EngineGeometry& exact, const Vector3& p, double reach_m);
bool MayMeetCap(const EngineGeometry& exact, const Pose& X_WS, const Ray& ray);

// The shape that the kernels use for a geometry that ExactEngine prepared: the given shape, or the
// hull of a convex shape's corners.
const Shape& ShapeOf(const EngineGeometry& exact);

// The triangle tree of a geometry that ExactEngine prepared, in the shape's frame; nullptr for
// everything but meshes.
const TriangleTree* TreeOf(const EngineGeometry& exact);

}  // namespace cwm::collision
