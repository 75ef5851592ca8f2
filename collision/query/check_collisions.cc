#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"
#include "collision/query/sphere_check.h"

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

PairVerdict Judge(const BodySearch::Pair& pair) {
  const double margin_m = pair.margin_m;
  const bool is_bullet =
      pair.engine.kind() == EngineKind::kBullet;  // it decides by distance itself
  if (margin_m == 0 && !HasStandIn(pair) && !is_bullet) {
    const bool collides = pair.engine.Collides(pair.body, pair.object);
    return {collides ? Verdict::kCollision : Verdict::kFree, TrustOfYesNo(pair)};
  }
  const PairDistance answer = pair.engine.Distance(pair.body, pair.object, std::max(0.0, margin_m));
  const Verdict verdict = Decide(answer, margin_m);
  const bool is_clear = verdict == Verdict::kFree && answer.trust != Trust::kDegraded;
  return {verdict, is_clear ? TrustOfYesNo(pair) : answer.trust};
}

// Gathers the verdict of a row, pair by pair.
class RowJudge {
 public:
  const RowVerdict& row() const { return row_; }
  bool is_decided() const { return row_.verdict == Verdict::kCollision; }

  // The reach beyond the margins that still matters: none once a pair collides, one is enough.
  double Add(const BodySearch::Pair& pair) {
    const PairVerdict told = Judge(pair);
    if (told.verdict == Verdict::kCollision) {
      row_ = {.verdict = Verdict::kCollision, .pair = pair.id, .trust = told.trust};
      return -1;
    }
    if (row_.verdict != Verdict::kUndecided) {
      if (told.verdict == Verdict::kUndecided) {
        row_ = {.verdict = Verdict::kUndecided, .pair = pair.id, .trust = told.trust};
      } else {
        row_.trust = std::max(row_.trust, told.trust);
      }
    }
    return 0;
  }

 private:
  RowVerdict row_;
};

RowVerdict JudgeRow(BodySearch& search) {
  RowJudge judge;
  const auto add = [&](const BodySearch::Pair& pair) { return judge.Add(pair); };
  search.ForEachSelfPair(BodySearch::From::kMargin, 0, Question::kCollides, add);
  if (judge.is_decided() || search.ended() || !search.asks_world()) return judge.row();
  if (search.body_bounds_W().isEmpty()) return judge.row();  // shown to be clear of the world
  const auto visit = [&](const Obstacle& object) {
    if (search.Skips(object)) return true;
    search.ForEachPair(object, BodySearch::From::kMargin, 0, Question::kCollides, add);
    return !judge.is_decided() && !search.ended();
  };
  search.world().bounds().ForEachWithin(search.body_bounds_W(),
                                        std::max(0.0, search.widest_margin_m()), visit);
  return judge.row();
}

// What spheres in lanes tell of rows, some rows ahead of their turn.
class KnownVerdicts {
 public:
  KnownVerdicts(std::optional<SphereCheck> spheres, std::size_t rows, Naming naming)
      : spheres_(std::move(spheres)), rows_(rows), naming_(naming) {}

  // kNotComputed: to be asked plainly about what `open` says.
  Verdict Of(std::size_t row, LaneOpen& open) {
    if (!spheres_) return Verdict::kNotComputed;
    if (row == end_) LookAhead();
    const std::size_t at = row - (end_ - some_.size());
    const Verdict told = some_[at];
    if (!spheres_->open().empty()) open = spheres_->open()[at];
    const bool lacks_name = told == Verdict::kCollision && naming_ == Naming::kEachRow;
    return told == Verdict::kUndecided || lacks_name ? Verdict::kNotComputed : told;
  }

 private:
  void LookAhead() {
    constexpr std::size_t kAhead = 1024;  // 0.1 ms
    const std::size_t count = std::min(kAhead, rows_ - end_);
    some_ = spheres_->Judge(end_, count);
    end_ += count;
  }

  std::optional<SphereCheck> spheres_;
  std::size_t rows_;
  Naming naming_;
  std::span<const Verdict> some_;  // of the rows before end_
  std::size_t end_ = 0;
};

void Reserve(CollisionColumns& columns, std::size_t rows) {
  columns.verdict.reserve(rows);
  columns.object.reserve(rows);
  columns.body_part.reserve(rows);
  columns.object_part.reserve(rows);
  columns.trust.reserve(rows);
}

void Append(CollisionColumns& columns, const RowVerdict& row, ObjectRanks& ranks) {
  columns.verdict.push_back(row.verdict);
  columns.object.push_back(row.pair.IsOfItself() ? kItself : ranks.Of(row.pair.object));
  columns.body_part.push_back(row.pair.body_part);
  columns.object_part.push_back(row.pair.object_part);
  columns.trust.push_back(row.trust);
}

}  // namespace

absl::StatusOr<CollisionColumns> CheckCollisions(const WorldSnapshot& world, const QueryBody& body,
                                                 const BodyRows& rows, const QueryOptions& options,
                                                 std::stop_token stop) {
  BodySearch search(world, body, options, std::move(stop));
  ObjectRanks ranks(world);

  CollisionColumns columns;
  Reserve(columns, rows.size());
  KnownVerdicts known(SphereCheck::Make(world, body, rows, options), rows.size(), options.naming);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (search.MustEnd()) break;
    LaneOpen open = BodySearch::kAllOpen;
    RowVerdict row{.verdict = known.Of(i, open), .pair = {}, .trust = Trust::kExact};
    if (row.verdict == Verdict::kNotComputed) {
      row.verdict = Verdict::kOutOfLimits;
      if (rows.IsWithinLimits(i)) {
        search.PlaceBody(rows, i, open);
        row = JudgeRow(search);
      }
    }
    if (search.ended()) break;
    row.trust = std::max(row.trust, body.best_trust);
    Append(columns, row, ranks);
    ++columns.completed;
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  // Every row has a verdict, those that time did not suffice for as well.
  while (columns.verdict.size() < rows.size()) {
    Append(columns, {.verdict = Verdict::kNotComputed, .pair = {}, .trust = Trust::kExact}, ranks);
  }
  return columns;
}

}  // namespace cwm::collision
