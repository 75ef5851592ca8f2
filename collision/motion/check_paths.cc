#include "collision/motion/check_paths.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "collision/query/row_chunks.h"

namespace cwm::collision {
namespace {

std::optional<std::size_t> FirstOutOfLimits(const Waypoints& waypoints, const Path& path) {
  for (std::size_t k = 0; k < path.row_count; ++k) {
    if (!waypoints.IsWithinLimits(path.first_row + k)) return k;
  }
  return std::nullopt;
}

// The rank of an edge's verdict: the first edge of the highest rank gives the path's answer, unless
// an edge is in contact.
int WeightOf(MotionVerdict verdict) {
  switch (verdict) {
    case MotionVerdict::kUndecided:
      return 2;
    case MotionVerdict::kGrazing:
      return 1;
    default:
      return 0;
  }
}

// The answer for one path. Void once the checker has ended.
MotionResult Follow(EdgeChecker& checker, const Waypoints& waypoints, const Path& path) {
  if (const auto row = FirstOutOfLimits(waypoints, path)) {
    return {.verdict = MotionVerdict::kOutOfLimits,
            .segment = static_cast<std::int32_t>(*row),
            .accuracy = checker.best_accuracy()};
  }
  MotionResult result;
  Accuracy weakest = Accuracy::kExact;
  for (std::size_t k = 0; k + 1 < path.row_count && !checker.MustEnd(); ++k) {
    MotionResult edge = checker.Check(waypoints, path.first_row + k);
    if (edge.verdict != MotionVerdict::kFree) edge.segment = static_cast<std::int32_t>(k);
    if (edge.verdict == MotionVerdict::kContact || checker.ended()) return edge;
    const bool is_free =
        edge.verdict == MotionVerdict::kFree && result.verdict == MotionVerdict::kFree;
    if (is_free) result.clearance_m = std::min(result.clearance_m, edge.clearance_m);
    if (k == 0 || WeightOf(edge.verdict) > WeightOf(result.verdict)) result = edge;
    weakest = std::max(weakest, edge.accuracy);
  }
  if (result.verdict != MotionVerdict::kUndecided) result.accuracy = weakest;
  return result;
}

void NameVariables(const Waypoints& waypoints, std::span<const Path> paths,
                   MotionColumns& columns) {
  for (std::size_t i = 0; i < columns.completed; ++i) {
    if (columns.verdict[i] != MotionVerdict::kOutOfLimits) continue;
    if (columns.variable.empty()) columns.variable.resize(paths.size(), -1);
    const std::size_t row = paths[i].first_row + static_cast<std::size_t>(columns.segment[i]);
    columns.variable[i] = waypoints.VariableOutOfLimits(row).value_or(-1);
  }
}

// chosen: a path takes from a tenth of a millisecond to several milliseconds.
constexpr std::size_t kPathsPerChunk = 8;

// The arguments of a call, and its answers.
struct Batch {
  const WorldSnapshot& world;
  const QueryBody& body;
  const Waypoints& waypoints;
  std::span<const Path> paths;
  const QueryOptions& options;
  std::stop_token stop;
  TimeLimit limit;
  std::vector<MotionResult> answers;  // by path
};

class PathWorker : public ChunkWorker {
 public:
  explicit PathWorker(Batch& batch)
      : batch_(batch), checker_(batch.world, batch.body, batch.options, {batch.stop, batch.limit}) {
    if (const JointRows* const rows = batch.waypoints.joint_rows()) {
      checker_.UseSpheresOf(batch.world, *rows, batch.options);
    }
  }

  ChunkResult Process(const RowChunk& chunk) override {
    std::size_t k = 0;
    for (; k < chunk.count && !checker_.MustEnd(); ++k) {
      const Path& path = batch_.paths[chunk.first + k];
      assert(path.row_count >= 2 && path.first_row + path.row_count <= batch_.waypoints.size());
      const MotionResult answer = Follow(checker_, batch_.waypoints, path);
      if (checker_.ended()) break;
      batch_.answers[chunk.first + k] = answer;
    }
    batch_.limit.Count(k);
    return {k, checker_.Finish()};
  }

 private:
  Batch& batch_;
  EdgeChecker checker_;
};

}  // namespace

absl::StatusOr<MotionColumns> CheckPaths(const WorldSnapshot& world, const QueryBody& body,
                                         const Waypoints& waypoints, std::span<const Path> paths,
                                         const QueryOptions& options, std::stop_token stop) {
  if (auto status = EdgeChecker::CheckEngine(options); !status.ok()) return status;
  Batch batch{.world = world,
              .body = body,
              .waypoints = waypoints,
              .paths = paths,
              .options = options,
              .stop = std::move(stop),
              .limit = TimeLimit(options),
              .answers = std::vector<MotionResult>(paths.size())};
  const auto completed = ProcessChunks(EqualChunks(paths.size(), kPathsPerChunk), options.threads,
                                       [&] { return std::make_unique<PathWorker>(batch); });
  if (!completed.ok()) return completed.status();
  MotionColumns columns;
  columns.completed = *completed;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    Append(columns, i < *completed ? batch.answers[i] : MotionResult{});
  }
  NameVariables(waypoints, paths, columns);
  return columns;
}

}  // namespace cwm::collision
