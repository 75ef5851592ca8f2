#include "collision/query/pair_rows.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "collision/kernels/contact_patch.h"
#include "collision/query/joint_gradients.h"
#include "collision/query/object_ranks.h"
#include "collision/query/row_chunks.h"

namespace cwm::collision {
namespace {

// chosen: a row takes some microseconds, some tens of microseconds near meshes.
constexpr std::size_t kRowsPerChunk = 128;

// What the workers of a query share.
struct PairBatch {
  TimeLimit limit;
  std::vector<PairColumns> results;  // by chunk
  std::atomic<std::size_t> answer_count = 0;
};

class PairWorker : public ChunkWorker {
 public:
  PairWorker(const PairQuery& query, int per_row,
             const std::function<std::unique_ptr<RowFinder>(BodySearch& search)>& make_finder,
             PairBatch& batch)
      : rows_(query.rows),
        per_row_(static_cast<std::size_t>(std::max(0, per_row))),
        by_frame_(query.options.pairs == DistancePairs::kLinks),
        max_answers_(query.options.max_answers),
        search_(query.world, query.body, query.options, {query.stop, batch.limit}),
        finder_(make_finder(search_)),
        ranks_(query.world),
        hidden_m_(query.body.hidden_m),
        batch_(batch) {
    if (query.options.joint_gradients) gradients_.emplace(query.body, *JointRowsOf(query));
  }

  ChunkResult Process(const RowChunk& chunk) override {
    PairColumns& columns = batch_.results[chunk.index];
    Reserve(columns, chunk.count, per_row_);
    while (columns.completed < chunk.count && !search_.MustEnd()) {
      const std::size_t row = chunk.first + columns.completed;
      search_.PlaceBody(rows_, row);
      const std::vector<FoundPair>& pairs = finder_->Find();
      if (search_.ended()) break;
      const bool is_uncertain = search_.MeetsHidden() || search_.MeetsCaps();
      if (is_uncertain) labelled_ = pairs;
      if (search_.MeetsCaps()) LabelCaps(labelled_);
      if (search_.MeetsHidden()) LabelHidden(labelled_);
      if (gradients_ && !AppendGradients(row, pairs, columns)) break;
      AppendRow(columns, is_uncertain ? labelled_ : pairs, ranks_);
      batch_.limit.Count(pairs.size());
      if (batch_.answer_count.fetch_add(pairs.size()) + pairs.size() > max_answers_) {
        return {columns.completed - 1,
                absl::OutOfRangeError("more answers than the batch may have")};
      }
    }
    return {columns.completed, search_.Finish()};
  }

 private:
  // Bounds the answers of a row, which are sorted, by what may be nearer or deeper unseen: hidden
  // spaces of the named object, for the first answer those of all objects. If the answers are those
  // of the body's frames, each frame has a first answer, and only its own parts count.
  void LabelHidden(std::vector<FoundPair>& pairs) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      FoundPair& pair = pairs[k];
      const int frame = search_.FrameOf(pair.id.body_part);
      const bool is_first =
          k == 0 || (by_frame_ && search_.FrameOf(pairs[k - 1].id.body_part) != frame);
      double least_m = pair.answer.distance_m;
      search_.ForEachHiddenSpace(BodySearch::From::kSurface, [&](const HiddenSpace& space,
                                                                 std::int32_t part, double gap_m) {
        if (space.object != pair.id.object && !is_first) return;
        if (by_frame_ && search_.FrameOf(part) != frame) return;
        const double depth_m = MinSeparation_m(search_.body_bounds_W(), space.bounds_W);
        least_m = std::min(least_m, gap_m > 0 ? gap_m : -depth_m);
      });
      least_m -= hidden_m_;
      if (least_m >= pair.answer.distance_m) continue;
      pair.answer.accuracy = std::max(pair.answer.accuracy, Accuracy::kBounded);
      pair.answer.bound_m = std::max(pair.answer.bound_m, pair.answer.distance_m - least_m);
    }
  }

  // Bounds the answers of a row by what closed holes of meshes leave open: those of the pair's own
  // parts, and for the nearest answer those of all pairs that it is the nearest of.
  void LabelCaps(std::vector<FoundPair>& pairs) {
    for (std::size_t k = 0; k < pairs.size() && !search_.ended(); ++k) {
      FoundPair& found = pairs[k];
      const double reach_m = std::abs(found.answer.distance_m) + found.answer.bound_m;
      const int frame = search_.FrameOf(found.id.body_part);
      const bool is_first =
          k == 0 || (by_frame_ && search_.FrameOf(pairs[k - 1].id.body_part) != frame);
      CapError error;
      const auto visit = [&](const BodySearch::Pair& pair) {
        const bool counts =
            (pair.id <=> found.id) == 0 ||
            (is_first && (!by_frame_ || search_.FrameOf(pair.id.body_part) == frame));
        if (!counts || !pair.has_caps()) return reach_m;
        const CapError of_pair = pair.CapErrorWithin(reach_m);
        error.apart_m = std::max(error.apart_m, of_pair.apart_m);
        error.depth_m = std::max(error.depth_m, of_pair.depth_m);
        return reach_m;
      };
      search_.ForEachSelfPair(BodySearch::From::kSurface, reach_m, QueryKind::kDistance, visit);
      const auto visit_object = [&](const Obstacle& object) {
        if (!search_.Skips(object)) {
          search_.ForEachPair(object, BodySearch::From::kSurface, reach_m, QueryKind::kDistance,
                              visit);
        }
        return !search_.ended();
      };
      if (search_.tests_world()) {
        search_.world().bounds().ForEachWithin(search_.body_bounds_W(), reach_m, visit_object);
      }
      found.answer = WithCapError(found.answer, error);
    }
  }

  // Appends the derivatives of the row's answers, with the body at its last placement. False, and
  // nothing is appended, if the batch must end.
  bool AppendGradients(std::size_t row, const std::vector<FoundPair>& pairs, PairColumns& columns) {
    gradients_->Place(row, search_.frames_W());
    for (const FoundPair& pair : pairs) {
      const int other_frame = pair.id.IsSelfPair() ? search_.FrameOf(pair.id.object_part) : -1;
      gradients_->Append(pair.answer, search_.FrameOf(pair.id.body_part), other_frame,
                         columns.joint_gradient);
      columns.gradient_kink.push_back(pair.is_tied || HasSeveralPoints(pair) ? 1 : 0);
    }
    if (!search_.ended()) return true;
    columns.gradient_kink.resize(columns.distance_m.size());
    columns.joint_gradient.resize(columns.distance_m.size() * gradients_->width());
    return false;
  }

  // True if other points of the two parts are as near as those of the answer, such as the corners
  // in which parallel faces meet.
  bool HasSeveralPoints(const FoundPair& found) {
    const auto pair = search_.PairOf(found.id, QueryKind::kDistance);
    if (!pair) return false;
    contacts_.clear();
    pair->engine.Contacts(pair->body, pair->object, found.answer.distance_m + kTieTolerance_m,
                          1 + kMaxPatchPoints, contacts_, pair->work);
    search_.CountPair(*pair);
    return std::ranges::any_of(contacts_, [&](const PairDistance& contact) {
      return (contact.point_a - found.answer.point_a).norm() > kTieTolerance_m;
    });
  }

  const BodyRows& rows_;
  const std::size_t per_row_;
  const bool by_frame_;  // true if the answers are those of each frame, in their order
  const std::size_t max_answers_;
  BodySearch search_;
  std::unique_ptr<RowFinder> finder_;
  ObjectRanks ranks_;
  const double hidden_m_;
  std::optional<JointGradients> gradients_;
  std::vector<FoundPair> labelled_;
  std::vector<PairDistance> contacts_;
  PairBatch& batch_;
};

}  // namespace

const JointRows* JointRowsOf(const PairQuery& query) {
  return dynamic_cast<const JointRows*>(&query.rows);
}

absl::StatusOr<PairColumns> FindPairs(
    const PairQuery& query, int per_row,
    const std::function<std::unique_ptr<RowFinder>(BodySearch& search)>& make_finder) {
  const std::vector<RowChunk> chunks = EqualChunks(query.rows.size(), kRowsPerChunk);
  PairBatch batch{.limit = TimeLimit(query.options),
                  .results = std::vector<PairColumns>(chunks.size()),
                  .answer_count = 0};
  const auto completed = ProcessChunks(chunks, query.options.threads, [&] {
    return std::make_unique<PairWorker>(query, per_row, make_finder, batch);
  });
  if (!completed.ok()) return completed.status();
  PairColumns columns = Joined(std::move(batch.results), *completed);
  LimitAccuracy(columns, query.body.best_accuracy);
  return columns;
}

}  // namespace cwm::collision
