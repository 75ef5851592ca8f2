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
        limit_(limit),
        results_(result) {}

  ChunkResult Process(const RowChunk& chunk) override {
    PairColumns& columns = results_[chunk.index];
    Reserve(columns, chunk.count, per_row_);
    while (columns.completed < chunk.count && !search_.MustEnd()) {
      search_.PlaceBody(rows_, chunk.first + columns.completed);
      const std::vector<FoundPair>& pairs = finder_->Find();
      if (search_.ended()) break;
      AppendRow(columns, pairs, ranks_);
      limit_.Count(pairs.size());
    }
    return {columns.completed, search_.Finish()};
  }

 private:
  const BodyRows& rows_;
  const std::size_t per_row_;
  BodySearch search_;
  std::unique_ptr<RowFinder> finder_;
  ObjectRanks ranks_;
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
