// FCL 0.7.0 behind a whitelist, a referee for collision checks and for the distance of separated
// pairs. These defects of FCL are worked around here:
//   - Pairs without a solver jump through a null pointer (Box-Halfspace distance, Convex-Plane).
//     The capability table excludes them, and the exact kernels answer.
//   - Where collide() has no closed form, it misses overlaps below its tolerance, and now and then
//     one of a centimetre (one in twenty pairs of cones). Its answer is labelled kDegraded.
//   - Signed distance (EPA) throws near touching, and otherwise an assertion may end the process
//     (Debian builds the library with assertions on). It is never used; the exact kernels measure
//     what FCL finds overlapping.
//   - The unsigned distance of an overlap is -1, of overlapping meshes 0. Only positive distances
//     are used.
//   - collide() measures depth along the ray between centres, up to 100 % too deep. Only its yes or
//     no is used.
//   - Meshes are surfaces. Containment is tested separately, and their depth is a bound.
//   - computeAABB uses the bounding sphere. broadphase/ has its own bounds.
#pragma once

#include "collision/engines/engine.h"

namespace cwm::collision {

class FclEngine final : public Engine {
 public:
  EngineKind kind() const override { return EngineKind::kFcl; }
  bool Supports(ShapeKind a, ShapeKind b, QueryKind query) const override;
  std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const override;
  Accuracy CollisionAccuracy(ShapeKind a, ShapeKind b) const override;
  bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                WorkCounter* work = nullptr) const override;
  PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        WorkCounter* work = nullptr) const override;
};

}  // namespace cwm::collision
