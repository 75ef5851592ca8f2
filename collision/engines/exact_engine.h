// The exact kernels as an engine.
#pragma once

#include <optional>

#include "collision/engines/engine.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::collision {

class ExactEngine final : public Engine {
 public:
  EngineKind kind() const override { return EngineKind::kExact; }
  bool Supports(ShapeKind a, ShapeKind b, Question question) const override;  // always
  std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const override;
  bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                WorkCounter* work = nullptr) const override;
  PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        WorkCounter* work = nullptr) const override;
  // As many as kernels/contact_patch.h finds.
  void Contacts(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                int max_count, std::vector<PairDistance>& contacts,
                WorkCounter* work = nullptr) const override;
};

// First hit of a ray with a geometry that ExactEngine prepared, in the frame of X_WS.
std::optional<RayHit> CastRay(const EngineGeometry& exact, const Pose& X_WS, const Ray& ray,
                              WorkCounter* work = nullptr);

// ExactLowerBound_m of two such geometries.
std::optional<double> LowerBound_m(const PlacedGeometry& a, const PlacedGeometry& b);

// What the kernels ask of such a geometry: the shape as it was given, or the hull of a convex one's
// corners.
const Shape& ShapeOf(const EngineGeometry& exact);

// The triangles of such a geometry, in the shape's frame; nullptr of all but meshes.
const TriangleTree* TreeOf(const EngineGeometry& exact);

}  // namespace cwm::collision
