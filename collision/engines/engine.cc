#include "collision/engines/engine.h"

#include <algorithm>

#include "collision/engines/bullet_engine.h"
#include "collision/engines/exact_engine.h"
#include "collision/engines/fcl_engine.h"

namespace cwm::collision {

std::string_view NameOf(EngineKind kind) {
  switch (kind) {
    case EngineKind::kExact:
      return "EXACT";
    case EngineKind::kFcl:
      return "FCL";
    case EngineKind::kBullet:
      return "BULLET";
  }
  return "?";
}

void Engine::Contacts(const PlacedGeometry& a, const PlacedGeometry& b, double max_distance_m,
                      int max_count, std::vector<PairDistance>& contacts, WorkCounter* work) const {
  if (max_count < 1) return;
  // The depth of an overlap is known only if the search is allowed to reach distance 0.
  const PairDistance deepest = Distance(a, b, std::max(0.0, max_distance_m), work);
  if (deepest.distance_m < max_distance_m) contacts.push_back(deepest);
}

const Engine& GetEngine(EngineKind kind) {
  static const ExactEngine exact;
  static const FclEngine fcl;
  static const BulletEngine bullet;
  switch (kind) {
    case EngineKind::kFcl:
      return fcl;
    case EngineKind::kBullet:
      return bullet;
    case EngineKind::kExact:
      break;
  }
  return exact;
}

std::shared_ptr<const EngineGeometry> Engine::Prepare(const Shape& shape) const {
  return PrepareFrom(PrepareExact(shape));
}

const Engine* BestEngine(ShapeKind a, ShapeKind b, QueryKind query) {
  for (const EngineKind kind : {EngineKind::kExact, EngineKind::kFcl, EngineKind::kBullet}) {
    const Engine& engine = GetEngine(kind);
    if (engine.Supports(a, b, query)) return &engine;
  }
  return nullptr;
}

}  // namespace cwm::collision
