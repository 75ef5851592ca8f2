#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "collision/query/body_search.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"
#include "collision/query/row_chunks.h"
#include "collision/query/sphere_check.h"

namespace cwm::collision {
namespace {

struct RowVerdict {
  Verdict verdict = Verdict::kFree;
  PairId pair;  // the pair that collides, else the first undecided one
  Accuracy accuracy =
      Accuracy::kExact;  // of that pair; for a free row the weakest of all tested pairs
};

struct PairVerdict {
  Verdict verdict;
  Accuracy accuracy;
};

// True if FCL or Bullet would test a cone, which they represent by circumscribed pieces: their yes
// or no is about the pieces, not the cone.
bool HasApproximation(const BodySearch::Pair& pair) {
  return pair.engine.kind() != EngineKind::kExact &&
         (pair.body.kind == ShapeKind::kCone || pair.object.kind == ShapeKind::kCone);
}

// The verdict on whether the true distance is strictly below the margin, given the answer's bound.
Verdict Decide(const PairDistance& answer, double margin_m) {
  // An overlap found by the kernels is certain; their bound only concerns its depth.
  const bool overlap_is_proven = answer.solver == Solver::kKernels && answer.distance_m < 0;
  if (overlap_is_proven && margin_m >= 0) return Verdict::kCollision;
  if (answer.distance_m + answer.bound_m < margin_m) return Verdict::kCollision;
  // A kDegraded distance is that of two witness points and thus only an upper bound.
  const bool is_known = answer.accuracy != Accuracy::kDegraded;
  const bool is_clear = is_known && answer.distance_m - answer.bound_m >= margin_m;
  return is_clear ? Verdict::kFree : Verdict::kUndecided;
}

PairVerdict EvaluatePair(const BodySearch::Pair& pair) {
  const double margin_m = pair.margin_m;
  const bool is_bullet =
      pair.engine.kind() == EngineKind::kBullet;  // its Collides measures the distance anyway
  if (margin_m == 0 && !HasApproximation(pair) && !is_bullet) {
    const bool collides = pair.engine.Collides(pair.body, pair.object, pair.work);
    return {collides ? Verdict::kCollision : Verdict::kFree, pair.YesNoAccuracy()};
  }
  // The kernels find an overlap much faster than its depth, which a positive margin does not need.
  if (margin_m > 0 && pair.engine.kind() == EngineKind::kExact &&
      pair.engine.Collides(pair.body, pair.object, pair.work)) {
    return {Verdict::kCollision, pair.YesNoAccuracy()};
  }
  const PairDistance answer =
      pair.engine.Distance(pair.body, pair.object, std::max(0.0, margin_m), pair.work);
  const Verdict verdict = Decide(answer, margin_m);
  const bool is_clear = verdict == Verdict::kFree && answer.accuracy != Accuracy::kDegraded;
  return {verdict, std::max(is_clear ? Accuracy::kExact : answer.accuracy, pair.ProofAccuracy())};
}

// Combines the verdicts of pairs into that of a row.
class RowVerdictBuilder {
 public:
  RowVerdictBuilder(const QueryBody& body, UnseenSpace unseen) : body_(body), unseen_(unseen) {}

  const RowVerdict& row() const { return row_; }
  bool is_decided() const { return row_.verdict == Verdict::kCollision; }

  // Adds a pair and returns the reach beyond the margins for the rest of the row: negative once a
  // pair collides, since one is enough.
  double Add(const BodySearch::Pair& pair) {
    PairVerdict result = EvaluatePair(pair);
    const bool is_uncertain =
        StandsForOthers(pair.id) ||
        (unseen_ == UnseenSpace::kReport && pair.id.object != nullptr && IsUnseen(*pair.id.object));
    if (is_uncertain && result.verdict == Verdict::kCollision) result.verdict = Verdict::kUndecided;
    if (result.verdict == Verdict::kCollision) {
      row_ = {.verdict = Verdict::kCollision, .pair = pair.id, .accuracy = result.accuracy};
      return -1;
    }
    if (row_.verdict != Verdict::kUndecided) {
      if (result.verdict == Verdict::kUndecided) {
        row_ = {.verdict = Verdict::kUndecided, .pair = pair.id, .accuracy = result.accuracy};
      } else {
        row_.accuracy = std::max(row_.accuracy, result.accuracy);
      }
    }
    return 0;
  }

 private:
  bool StandsForOthers(const PairId& pair) const {
    return body_.IsContaining(pair.body_part) ||
           (pair.IsSelfPair() && body_.IsContaining(pair.object_part));
  }

  const QueryBody& body_;
  UnseenSpace unseen_;
  RowVerdict row_;
};

// Calls add(pair) for the pairs of a row whose boxes do not prove them apart. It returns the reach
// beyond the margins for the rest of the row, negative once the row is decided.
template <class Add>
void ForEachNearPair(BodySearch& search, Add&& add) {
  bool is_decided = false;
  const auto visit_pair = [&](const BodySearch::Pair& pair) {
    const double reach_m = add(pair);
    is_decided = reach_m < 0;
    return reach_m;
  };
  search.ForEachSelfPair(BodySearch::From::kMargin, 0, QueryKind::kCollides, visit_pair);
  if (is_decided || search.ended() || !search.tests_world()) return;
  if (search.body_bounds_W().isEmpty()) return;  // no open frame is left to test against the world
  const auto visit = [&](const Obstacle& object) {
    if (search.Skips(object)) return true;
    search.ForEachPair(object, BodySearch::From::kMargin, 0, QueryKind::kCollides, visit_pair);
    return !is_decided && !search.ended();
  };
  search.world().bounds().ForEachWithin(search.body_bounds_W(),
                                        std::max(0.0, search.max_margin_m()), visit);
}

// The accuracy of a free row whose pairs have the given one.
Accuracy WithHidden(BodySearch& search, Accuracy accuracy) {
  if (accuracy != Accuracy::kExact || !search.MeetsHidden()) return accuracy;
  return search.HiddenAccuracy([](std::int32_t) { return 0.0; });
}

RowVerdict EvaluateRow(BodySearch& search, UnseenSpace unseen) {
  RowVerdictBuilder builder(search.body(), unseen);
  ForEachNearPair(search, [&](const BodySearch::Pair& pair) { return builder.Add(pair); });
  RowVerdict row = builder.row();
  if (row.verdict == Verdict::kFree) row.accuracy = WithHidden(search, row.accuracy);
  return row;
}

// The accuracy that EvaluateRow would return for a free row with the exact kernels, found without
// testing any pair.
Accuracy FreeRowAccuracy(BodySearch& search) {
  Accuracy accuracy = Accuracy::kExact;
  ForEachNearPair(search, [&](const BodySearch::Pair& pair) {
    accuracy = std::max(accuracy, pair.ProofAccuracy());
    return accuracy >= Accuracy::kSurfaceOnly ? -1 : 0;
  });
  return WithHidden(search, accuracy);
}

// Rows of a chunk. measured: sphere states take 0.1 us each by SIMD, which gains from sorting many
// states; others take up to some 10 us.
constexpr std::size_t kSphereRowsPerChunk = 1024, kOtherRowsPerChunk = 256;

// Yields the frames of given rows in order and places several rows at a time.
class PlacedRows {
 public:
  explicit PlacedRows(const BodyRows& rows, int frame_count)
      : rows_(rows), frames_(static_cast<std::size_t>(frame_count)), X_WF_(kAtOnce * frames_) {}

  void Begin(std::vector<std::size_t> order) {
    order_ = std::move(order);
    next_ = placed_ = 0;
  }
  // The frames of the next row, valid until the next call.
  std::span<const Pose> Next() {
    if (next_ == placed_) {
      const std::size_t count = std::min(kAtOnce, order_.size() - placed_);
      rows_.PlaceRows(std::span(order_).subspan(placed_, count),
                      std::span(X_WF_).first(count * frames_));
      first_ = placed_;
      placed_ += count;
    }
    return std::span(X_WF_).subspan((next_++ - first_) * frames_, frames_);
  }

 private:
  static constexpr std::size_t kAtOnce = 8;  // the number of double-precision SIMD lanes

  const BodyRows& rows_;
  const std::size_t frames_;
  std::vector<Pose> X_WF_;
  std::vector<std::size_t> order_;
  std::size_t next_ = 0, first_ = 0, placed_ = 0;
};

// Makes `rows` rows of which those from `first` on are kNotComputed, as those stay that are not
// reached before the deadline, and as those become that other threads answered after an early end.
void ResetRows(std::size_t first, std::size_t rows, CollisionColumns& columns) {
  const auto reset = [&](auto& column, const auto& value) {
    column.resize(first);
    column.resize(rows, value);
  };
  reset(columns.verdict, Verdict::kNotComputed);
  reset(columns.object, -1);
  reset(columns.body_part, -1);
  reset(columns.object_part, -1);
  reset(columns.accuracy, Accuracy::kDegraded);
}

// The query and its result.
struct CollisionBatch {
  const WorldSnapshot& world;
  const QueryBody& body;
  const BodyRows& rows;
  const QueryOptions& options;
  std::stop_token stop;
  TimeLimit limit;
  std::optional<SphereCheck> spheres;  // each worker uses a copy
  CollisionColumns columns;
};

class Checker : public ChunkWorker {
 public:
  explicit Checker(CollisionBatch& batch)
      : batch_(batch),
        search_(batch.world, batch.body, batch.options, {batch.stop, batch.limit}),
        ranks_(batch.world),
        spheres_(batch.spheres),
        placed_(batch.rows, batch.body.frame_count) {}

  ChunkResult Process(const RowChunk& chunk) override {
    std::span<const Verdict> known;  // verdicts of the sphere check, for all rows at once
    if (spheres_ && !search_.MustEnd()) known = spheres_->Check(chunk.first, chunk.count);
    const auto is_known = [&](std::size_t k) { return !known.empty() && IsFinal(known[k]); };
    std::vector<std::size_t> open_rows;
    for (std::size_t k = 0; k < chunk.count; ++k) {
      if (!is_known(k) || NeedsAccuracy(known[k])) open_rows.push_back(chunk.first + k);
    }
    placed_.Begin(std::move(open_rows));
    std::size_t k = 0;
    for (; k < chunk.count && !search_.MustEnd(); ++k) {
      const RowVerdict result = is_known(k) ? Known(chunk.first + k, known[k])
                                            : EvaluateExactly(chunk, k, OpenOf(known, k));
      if (search_.ended()) break;
      Write(chunk.first + k, result);
    }
    batch_.limit.Count(k);
    return {k, search_.Finish()};
  }

 private:
  bool IsFinal(Verdict known) const {
    if (known == Verdict::kCollision) return batch_.options.naming != Naming::kEachRow;
    return known != Verdict::kUndecided;
  }

  // What is left to be tested of the k-th row of a chunk.
  UnresolvedTags OpenOf(std::span<const Verdict> known, std::size_t k) const {
    const bool is_partly_known = !known.empty() && known[k] == Verdict::kUndecided;
    return is_partly_known ? spheres_->open(k) : BodySearch::kAllUnresolved;
  }

  // True if the sphere check decided the verdict but not its accuracy.
  bool NeedsAccuracy(Verdict verdict) const {
    return verdict == Verdict::kFree && spheres_ && spheres_->needs_accuracy_tests();
  }

  RowVerdict Known(std::size_t row, Verdict verdict) {
    RowVerdict result{.verdict = verdict, .pair = {}};
    if (NeedsAccuracy(verdict)) result.accuracy = FreeAccuracy(row, placed_.Next());
    return result;
  }

  // True if the k-th row of a chunk is within limits.
  bool IsWithinLimits(const RowChunk& chunk, std::size_t k) const {
    const bool is_known = spheres_ && spheres_->IsKnownWithinLimits(k);
    return is_known || batch_.rows.IsWithinLimits(chunk.first + k);
  }

  RowVerdict EvaluateExactly(const RowChunk& chunk, std::size_t k, const UnresolvedTags& open) {
    const std::span<const Pose> X_WF = placed_.Next();
    if (!IsWithinLimits(chunk, k)) return {.verdict = Verdict::kOutOfLimits, .pair = {}};
    const std::size_t row = chunk.first + k;
    search_.PlaceBody(X_WF, row, open);
    RowVerdict result = EvaluateRow(search_, batch_.options.unseen);
    if (NeedsAccuracy(result.verdict)) result.accuracy = FreeAccuracy(row, X_WF);
    return result;
  }

  Accuracy FreeAccuracy(std::size_t row, std::span<const Pose> X_WF) {
    search_.PlaceBody(X_WF, row, spheres_->tags_for_accuracy());
    return FreeRowAccuracy(search_);
  }

  void Write(std::size_t row, const RowVerdict& result) {
    CollisionColumns& columns = batch_.columns;
    columns.verdict[row] = result.verdict;
    // What contains the body and is free proves the body free.
    const bool is_proof = result.verdict == Verdict::kFree && batch_.body.containing_count > 0;
    columns.accuracy[row] =
        is_proof ? result.accuracy : std::max(result.accuracy, batch_.body.best_accuracy);
    columns.object[row] =
        result.pair.IsSelfPair() ? kSelfObject : ranks_.IndexOf(result.pair.object);
    columns.body_part[row] = result.pair.body_part;
    columns.object_part[row] = result.pair.object_part;
  }

  CollisionBatch& batch_;
  BodySearch search_;
  ObjectRanks ranks_;
  std::optional<SphereCheck> spheres_;
  PlacedRows placed_;
};

// Fills the column of variables. Rows out of limits are tested a second time, since they are few.
void NameVariables(const BodyRows& rows, CollisionColumns& columns) {
  for (std::size_t row = 0; row < columns.completed; ++row) {
    if (columns.verdict[row] != Verdict::kOutOfLimits) continue;
    if (columns.variable.empty()) columns.variable.resize(rows.size(), -1);
    columns.variable[row] = rows.VariableOutOfLimits(row).value_or(-1);
  }
}

}  // namespace

absl::StatusOr<CollisionColumns> CheckCollisions(const WorldSnapshot& world, const QueryBody& body,
                                                 const BodyRows& rows, const QueryOptions& options,
                                                 std::stop_token stop) {
  CollisionBatch batch{.world = world,
                       .body = body,
                       .rows = rows,
                       .options = options,
                       .stop = std::move(stop),
                       .limit = TimeLimit(options),
                       .spheres = SphereCheck::Make(world, body, rows, options),
                       .columns = {}};
  ResetRows(0, rows.size(), batch.columns);
  const bool is_spheres = batch.spheres && batch.spheres->decides_collisions();
  const auto completed =
      ProcessChunks(EqualChunks(rows.size(), is_spheres ? kSphereRowsPerChunk : kOtherRowsPerChunk),
                    options.threads, [&] { return std::make_unique<Checker>(batch); });
  if (!completed.ok()) return completed.status();
  ResetRows(*completed, rows.size(), batch.columns);
  batch.columns.completed = *completed;
  if (options.naming == Naming::kEachRow) NameVariables(rows, batch.columns);
  return std::move(batch.columns);
}

}  // namespace cwm::collision
