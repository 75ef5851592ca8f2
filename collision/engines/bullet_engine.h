// Bullet 3.24 (float64), the second, independent referee. AUTO uses it only if no other engine
// supports the pair. These defects of Bullet are worked around here:
//   - The default margins are 4 cm. They are set to zero on every shape (bullet_geometry).
//   - The dispatcher and its pools are not thread safe. btGjkPairDetector is called directly, with
//     solvers on the stack.
//   - Concave-concave and plane-concave pairs return nothing, without an error. The capability
//     table excludes them.
//   - Meshes are surfaces. Containment is tested separately.
//   - Depth near contact is unreliable without margins. It is labelled kDegraded.
#pragma once

#include "collision/engines/engine.h"

namespace cwm::collision {

class BulletEngine final : public Engine {
 public:
  EngineKind kind() const override { return EngineKind::kBullet; }
  bool Supports(ShapeKind a, ShapeKind b, QueryKind query) const override;
  std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const override;
  bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                WorkCounter* work = nullptr) const override;
  PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        WorkCounter* work = nullptr) const override;
};

}  // namespace cwm::collision
