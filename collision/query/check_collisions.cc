#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

struct RowVerdict {
  Verdict verdict = Verdict::kFree;
  PairId pair;                  // that collides or, first of all, stays undecided
  Trust trust = Trust::kExact;  // of that pair; of a free row, the weakest of all pairs asked
};

struct PairVerdict {
  Verdict verdict;
  Trust trust;
};

// Yes and no needs no label of its own but where a surface has no inside.
Trust TrustOfYesNo(const BodySearch::Pair& pair) {
  return pair.has_open_mesh ? Trust::kSurfaceOnly : Trust::kExact;
}

// FCL and Bullet hold cones as circumscribed pieces: their yes or no is one about the pieces.
bool HasStandIn(const BodySearch::Pair& pair) {
  return pair.engine.kind() != EngineKind::kExact &&
         (pair.body.kind == ShapeKind::kCone || pair.object.kind == ShapeKind::kCone);
}

// Whether the true distance lies below the margin, as far as the answer can tell.
Verdict Decide(const PairDistance& answer, double margin_m) {
  // The kernels call an overlap what is one; their bound is about its depth.
  const bool overlap_is_proven = answer.solver == Solver::kKernels && answer.distance_m < 0;
  if (overlap_is_proven && margin_m >= 0) return Verdict::kCollision;
  if (std::abs(answer.distance_m - margin_m) <= answer.bound_m) return Verdict::kUndecided;
  if (answer.distance_m < margin_m) return Verdict::kCollision;
  // Witnesses bound a distance from above only.
  return answer.trust == Trust::kDegraded ? Verdict::kUndecided : Verdict::kFree;
}

PairVerdict Judge(const BodySearch::Pair& pair, double margin_m) {
  const bool is_bullet =
      pair.engine.kind() == EngineKind::kBullet;  // it decides by distance itself
  if (margin_m == 0 && !HasStandIn(pair) && !is_bullet) {
    const bool collides = pair.engine.Collides(pair.body, pair.object);
    return {collides ? Verdict::kCollision : Verdict::kFree, TrustOfYesNo(pair)};
  }
  const PairDistance answer = pair.engine.Distance(pair.body, pair.object, margin_m);
  const Verdict verdict = Decide(answer, margin_m);
  const bool is_clear = verdict == Verdict::kFree && answer.trust != Trust::kDegraded;
  return {verdict, is_clear ? TrustOfYesNo(pair) : answer.trust};
}

RowVerdict JudgeRow(BodySearch& search, double own_margin_m, double widest_margin_m) {
  RowVerdict row;
  const auto visit = [&](const WorldObject& object) {
    if (search.Skips(object)) return true;
    const double margin_m = object.margin_m + own_margin_m;
    const Question question = margin_m == 0 ? Question::kCollides : Question::kDistance;
    const double reach_m = std::max(0.0, margin_m);
    search.ForEachPair(object, reach_m, question, [&](const BodySearch::Pair& pair) {
      const PairVerdict told = Judge(pair, margin_m);
      if (told.verdict == Verdict::kCollision) {
        row = {.verdict = Verdict::kCollision, .pair = pair.id, .trust = told.trust};
        return -1.0;  // one pair is enough
      }
      if (row.verdict == Verdict::kUndecided) return reach_m;
      if (told.verdict == Verdict::kUndecided) {
        row = {.verdict = Verdict::kUndecided, .pair = pair.id, .trust = told.trust};
      } else {
        row.trust = std::max(row.trust, told.trust);
      }
      return reach_m;
    });
    return row.verdict != Verdict::kCollision && !search.ended();
  };
  search.world().bounds().ForEachWithin(search.body_bounds_W(), std::max(0.0, widest_margin_m),
                                        visit);
  return row;
}

void Reserve(CollisionColumns& columns, std::size_t rows) {
  columns.verdict.reserve(rows);
  columns.object.reserve(rows);
  columns.body_part.reserve(rows);
  columns.object_part.reserve(rows);
  columns.trust.reserve(rows);
}

void Append(CollisionColumns& columns, const RowVerdict& row, ObjectRanks& ranks) {
  columns.verdict.push_back(row.verdict);
  columns.object.push_back(ranks.Of(row.pair.object));
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
  const double own_margin_m = body.margin_m + options.margin_m;
  const double widest_margin_m = world.objects().widest_margin_m() + own_margin_m;
  ObjectRanks ranks(world);

  CollisionColumns columns;
  Reserve(columns, X_WB.size());
  for (const Pose& X : X_WB) {
    if (search.MustEnd()) break;
    search.PlaceBody(X);
    const RowVerdict row = JudgeRow(search, own_margin_m, widest_margin_m);
    if (search.ended()) break;
    Append(columns, row, ranks);
    ++columns.completed;
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  // Every row has a verdict, those that time did not suffice for as well.
  while (columns.verdict.size() < X_WB.size()) {
    Append(columns, {.verdict = Verdict::kNotComputed, .pair = {}, .trust = Trust::kExact}, ranks);
  }
  return columns;
}

}  // namespace cwm::collision
