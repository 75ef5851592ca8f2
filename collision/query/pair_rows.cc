#include "collision/query/pair_rows.h"

#include <algorithm>
#include <utility>

#include "collision/query/object_ranks.h"
#include "collision/query/row_chunks.h"

namespace cwm::collision {
namespace {

// chosen: a row takes some microseconds, some tens of microseconds near meshes.
constexpr std::size_t kRowsPerChunk = 128;

class PairWorker : public ChunkWorker {
 public:
  PairWorker(const PairQuery& query, int per_row,
             const std::function<std::unique_ptr<RowFinder>(BodySearch& search)>& make_finder,
             TimeLimit& limit, std::vector<PairColumns>& result)
      : rows_(query.rows),
        per_row_(static_cast<std::size_t>(std::max(0, per_row))),
        search_(query.world, query.body, query.options, {query.stop, limit}),
        finder_(make_finder(search_)),
        ranks_(query.world),
        hidden_m_(query.body.hidden_m),
        limit_(limit),
        results_(result) {}

  ChunkResult Process(const RowChunk& chunk) override {
    PairColumns& columns = results_[chunk.index];
    Reserve(columns, chunk.count, per_row_);
    while (columns.completed < chunk.count && !search_.MustEnd()) {
      search_.PlaceBody(rows_, chunk.first + columns.completed);
      const std::vector<FoundPair>& pairs = finder_->Find();
      if (search_.ended()) break;
      if (search_.MeetsHidden()) {
        labelled_ = pairs;
        LabelHidden(labelled_);
      }
      AppendRow(columns, search_.MeetsHidden() ? labelled_ : pairs, ranks_);
      limit_.Count(pairs.size());
    }
    return {columns.completed, search_.Finish()};
  }

 private:
  // Bounds the answers of a row, which are sorted, by what may be nearer or deeper unseen: hidden
  // spaces of the named object, for the first answer those of all objects.
  void LabelHidden(std::vector<FoundPair>& pairs) {
    for (FoundPair& pair : pairs) {
      double least_m = pair.answer.distance_m;
      search_.ForEachHiddenSpace(
          BodySearch::From::kSurface, [&](const HiddenSpace& space, std::int32_t, double gap_m) {
            if (space.object != pair.id.object && &pair != &pairs.front()) return;
            const double depth_m = MinSeparation_m(search_.body_bounds_W(), space.bounds_W);
            least_m = std::min(least_m, gap_m > 0 ? gap_m : -depth_m);
          });
      least_m -= hidden_m_;
      if (least_m >= pair.answer.distance_m) continue;
      pair.answer.accuracy = std::max(pair.answer.accuracy, Accuracy::kBounded);
      pair.answer.bound_m = std::max(pair.answer.bound_m, pair.answer.distance_m - least_m);
    }
  }

  const BodyRows& rows_;
  const std::size_t per_row_;
  BodySearch search_;
  std::unique_ptr<RowFinder> finder_;
  ObjectRanks ranks_;
  const double hidden_m_;
  std::vector<FoundPair> labelled_;
  TimeLimit& limit_;
  std::vector<PairColumns>& results_;
};

}  // namespace

absl::StatusOr<PairColumns> FindPairs(
    const PairQuery& query, int per_row,
    const std::function<std::unique_ptr<RowFinder>(BodySearch& search)>& make_finder) {
  const std::vector<RowChunk> chunks = EqualChunks(query.rows.size(), kRowsPerChunk);
  std::vector<PairColumns> result(chunks.size());  // by chunk
  TimeLimit limit(query.options);
  const auto completed = ProcessChunks(chunks, query.options.threads, [&] {
    return std::make_unique<PairWorker>(query, per_row, make_finder, limit, result);
  });
  if (!completed.ok()) return completed.status();
  PairColumns columns = Joined(std::move(result), *completed);
  LimitAccuracy(columns, query.body.best_accuracy);
  return columns;
}

}  // namespace cwm::collision
