// Engines are stateless solvers of pairs behind one interface. One broadphase, one filter and one
// margin path serve them all (query/). What an engine may be asked is decided by its table of trust
// (`Supports`); a pair outside it is never passed on, because FCL 0.7.0 jumps through a null
// pointer for some and Bullet silently answers nothing.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_answer.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

class ExactGeometry;  // kernels/exact.h

enum class EngineKind { kExact, kFcl, kBullet };
inline constexpr int kEngineCount = 3;
std::string_view NameOf(EngineKind kind);  // "EXACT", "FCL", "BULLET"

enum class Question { kCollides, kDistance, kContacts };

// An engine's own, immutable form of a shape (BVH, btCollisionShape). Built once with the model,
// never by a move.
class EngineGeometry {
 public:
  virtual ~EngineGeometry() = default;
};

struct PlacedGeometry {
  ShapeKind kind;
  const EngineGeometry& geometry;  // prepared by the engine that is asked
  const Pose& X_WS;
};

// Thread safe: all methods may be called at the same time on the same geometries.
class Engine {
 public:
  virtual ~Engine() = default;

  virtual EngineKind kind() const = 0;

  // Whether this engine answers `question` for the pair, in either order.
  virtual bool Supports(ShapeKind a, ShapeKind b, Question question) const = 0;

  // Whole and valid shapes only (FindViolation); never null. Heavy for meshes.
  std::shared_ptr<const EngineGeometry> Prepare(const Shape& shape) const;
  // The same from the kernels' form of the shape, which all engines share: containment and fallback
  // come from it.
  virtual std::shared_ptr<const EngineGeometry> PrepareFrom(
      std::shared_ptr<const ExactGeometry> exact) const = 0;

  // Precondition of the three: Supports(a.kind, b.kind, question). `Collides` is true when the
  // solids overlap (distance < 0; touching within 1e-9 m may count either way); containment in a
  // closed solid is an overlap. `work` as for ExactDistance: the kernels alone count and can be ended
  // within a pair.
  virtual bool Collides(const PlacedGeometry& a, const PlacedGeometry& b,
                        WorkCounter* work = nullptr) const = 0;

  // How far what Collides says of closed shapes may be believed: kExact, or kDegraded where a search
  // may miss an overlap.
  virtual Trust TrustOfCollides(ShapeKind, ShapeKind) const { return Trust::kExact; }

  // See ExactDistance for `max_distance_m`.
  virtual PairDistance Distance(const PlacedGeometry& a, const PlacedGeometry& b,
                                double max_distance_m, WorkCounter* work = nullptr) const = 0;

  // Contacts are answers with distance_m < max_distance_m, deepest first, appended to `contacts`,
  // at most `max_count` of them; the first is Distance's answer where that is below max_distance_m.
  // Here: that one alone, which is what every engine can say reliably (FCL gives one per primitive
  // pair, Bullet's grow over frames in a persistent manifold).
  virtual void Contacts(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                        int max_count, std::vector<PairDistance>& contacts,
                        WorkCounter* work = nullptr) const;
};

// The three engines, living as long as the process.
const Engine& GetEngine(EngineKind kind);

// The engine that `AUTO` uses for the pair: exact kernels first, then whichever the table of trust
// names. Never null: the kernels answer every pair.
const Engine* BestEngine(ShapeKind a, ShapeKind b, Question question);

}  // namespace cwm::collision
