// Bullet 3.24 (float64): the second, independent referee. It takes no part in AUTO where another
// engine answers. What was found wrong in it, and is walled off here:
//   - default margins of 4 cm: zero on every shape (bullet_geometry);
//   - the dispatcher and its pools are not thread safe: btGjkPairDetector is called directly, with
//     solvers on the stack;
//   - concave-concave and plane-concave answer nothing, without an error: not in the table;
//   - meshes are surfaces: containment is tested beside it;
//   - depth near contact is unreliable without margins: labelled kDegraded.
#pragma once

#include "collision/engines/engine.h"

namespace cwm::collision {

class BulletEngine final : public Engine {
 public:
  EngineKind kind() const override { return EngineKind::kBullet; }
  bool Supports(ShapeKind a, ShapeKind b, Question question) const override;
  std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const override;
  bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                WorkCounter* work = nullptr) const override;
  PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        WorkCounter* work = nullptr) const override;
};

}  // namespace cwm::collision
