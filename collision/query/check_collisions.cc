#include <algorithm>
#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

struct RowVerdict {
  bool collides = false;
  PairId pair;                  // that collides
  Trust trust = Trust::kExact;  // of that pair; of a free row, the weakest of all pairs asked
};

// Yes and no needs no label of its own but where a surface has no inside or pieces stand in.
Trust TrustOfYesNo(const BodySearch::Pair& pair) {
  if (pair.has_open_mesh) return Trust::kSurfaceOnly;
  const auto approximated = [](ShapeKind kind) {
    return kind == ShapeKind::kCone || kind == ShapeKind::kPlate;
  };
  const bool exact = pair.engine.kind() == EngineKind::kExact;
  return !exact && (approximated(pair.body.kind) || approximated(pair.object.kind))
             ? Trust::kBounded
             : Trust::kExact;
}

bool Collides(const BodySearch::Pair& pair, double margin_m, Trust& trust) {
  if (margin_m == 0) {
    trust = TrustOfYesNo(pair);
    return pair.engine.Collides(pair.body, pair.object);
  }
  const PairDistance answer = pair.engine.Distance(pair.body, pair.object, margin_m);
  trust = answer.distance_m > margin_m ? TrustOfYesNo(pair) : answer.trust;
  return answer.distance_m < margin_m;
}

RowVerdict Judge(BodySearch& search, double request_margin_m, double widest_margin_m) {
  RowVerdict row;
  search.world().bounds().ForEachWithin(
      search.body_bounds_W(), std::max(0.0, widest_margin_m), [&](std::uint32_t i) {
        if (search.Skips(i)) return true;
        const double margin_m = search.world().objects()[i]->margin_m + request_margin_m;
        const Question question = margin_m == 0 ? Question::kCollides : Question::kDistance;
        const double reach_m = std::max(0.0, margin_m);
        search.ForEachPair(i, reach_m, question, [&](const BodySearch::Pair& pair) {
          Trust trust = Trust::kExact;
          if (Collides(pair, margin_m, trust)) {
            row = {.collides = true, .pair = pair.id, .trust = trust};
            return -1.0;  // one pair is enough
          }
          row.trust = std::max(row.trust, trust);
          return reach_m;
        });
        return !row.collides && !search.ended();
      });
  return row;
}

void Reserve(CollisionColumns& columns, std::size_t rows) {
  columns.verdict.reserve(rows);
  columns.object.reserve(rows);
  columns.body_part.reserve(rows);
  columns.object_part.reserve(rows);
  columns.trust.reserve(rows);
}

void Append(CollisionColumns& columns, Verdict verdict, const RowVerdict& row) {
  columns.verdict.push_back(verdict);
  columns.object.push_back(row.pair.object);
  columns.body_part.push_back(row.pair.body_part);
  columns.object_part.push_back(row.pair.object_part);
  columns.trust.push_back(row.trust);
}

}  // namespace

absl::StatusOr<CollisionColumns> CheckCollisions(const WorldSnapshot& world, const QueryBody& body,
                                                 std::span<const Pose> X_WB,
                                                 const QueryOptions& options,
                                                 std::stop_token stop) {
  BodySearch search(world, body, options, std::move(stop));
  double widest_margin_m = 0;
  for (const WorldObjectPtr& object : world.objects()) {
    widest_margin_m = std::max(widest_margin_m, object->margin_m);
  }
  widest_margin_m += options.margin_m;

  CollisionColumns columns;
  Reserve(columns, X_WB.size());
  for (const Pose& X : X_WB) {
    if (search.MustEnd()) break;
    search.PlaceBody(X);
    const RowVerdict row = Judge(search, options.margin_m, widest_margin_m);
    if (search.ended()) break;
    Append(columns, row.collides ? Verdict::kCollision : Verdict::kFree, row);
    ++columns.completed;
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  // Every row has a verdict, those that time did not suffice for as well.
  while (columns.verdict.size() < X_WB.size()) Append(columns, Verdict::kNotComputed, {});
  return columns;
}

}  // namespace cwm::collision
