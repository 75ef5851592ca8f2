// Engines are stateless solvers of pairs behind one interface. One broad phase, one filter and one
// margin path serve them all (query/). An engine's capability table decides which pairs reach its
// library. Other pairs are unsupported (`Supports`) or answered by the exact kernels, because FCL
// 0.7.0 jumps through a null pointer for some pairs and Bullet silently answers nothing.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_distance.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

class ExactGeometry;  // kernels/exact.h

enum class EngineKind { kExact, kFcl, kBullet };
inline constexpr int kEngineCount = 3;
std::string_view NameOf(EngineKind kind);  // "EXACT", "FCL", "BULLET"

enum class QueryKind { kCollides, kDistance, kContacts };

// An engine's own, immutable representation of a shape (BVH, btCollisionShape). It is built once
// with the model and kept when the object moves.
class EngineGeometry {
 public:
  virtual ~EngineGeometry() = default;
};

struct PlacedGeometry {
  ShapeKind kind;
  const EngineGeometry& geometry;  // prepared by the engine that answers
  const Pose& X_WS;
};

// Thread safe: all methods may be called at the same time on the same geometries.
class Engine {
 public:
  virtual ~Engine() = default;

  virtual EngineKind kind() const = 0;

  // True if this engine answers `query` for the pair, in either order.
  virtual bool Supports(ShapeKind a, ShapeKind b, QueryKind query) const = 0;

  // Builds the engine's form of a valid shape (FindViolation). Never null. Slow for meshes.
  std::shared_ptr<const EngineGeometry> Prepare(const Shape& shape) const;
  // Same as Prepare, from the kernels' form of the shape, which all engines share for containment
  // tests and as a fallback.
  virtual std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const = 0;

  // True if the solids overlap (distance < 0); touching within 1e-9 m may count either way.
  // Containment in a closed solid is an overlap. Precondition of Collides, Distance and Contacts:
  // Supports(a.kind, b.kind, query). `work` is used as in ExactDistance; the kernels alone count
  // their work and can be stopped within a pair.
  virtual bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                        WorkCounter* work = nullptr) const = 0;

  // The accuracy of Collides for closed shapes: kExact, or kDegraded if its search may miss an
  // overlap.
  virtual Accuracy CollisionAccuracy(ShapeKind, ShapeKind) const { return Accuracy::kExact; }

  // The signed distance of the pair. See ExactDistance for `max_distance_m`.
  virtual PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b,
                                double max_distance_m, WorkCounter* work = nullptr) const = 0;

  // Appends the contacts with distance_m < max_distance_m to `contacts`, deepest first, at most
  // `max_count` of them. The first is Distance's answer, if that is below max_distance_m. The
  // default implementation appends only that one, which every engine can compute reliably: FCL
  // returns one contact per primitive pair, and Bullet's persistent manifold collects contacts over
  // several frames.
  virtual void Contacts(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        int max_count, std::vector<PairDistance>& contacts,
                        WorkCounter* work = nullptr) const;
};

// One of the three engines, which live as long as the process.
const Engine& GetEngine(EngineKind kind);

// The engine that `AUTO` uses for the pair: the first of exact, FCL and Bullet that supports it.
// Never null, because the kernels answer every pair.
const Engine* BestEngine(ShapeKind a, ShapeKind b, QueryKind query);

}  // namespace cwm::collision
