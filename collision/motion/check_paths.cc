#include "collision/motion/check_paths.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

namespace cwm::collision {
namespace {

std::optional<std::size_t> FirstOutOfLimits(const Waypoints& waypoints, const Path& path) {
  for (std::size_t k = 0; k < path.row_count; ++k) {
    if (!waypoints.IsWithinLimits(path.first_row + k)) return k;
  }
  return std::nullopt;
}

// Which of two answers of edges stays that of the path, short of a contact.
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

// Void once the checker has ended.
MotionAnswer Follow(EdgeChecker& checker, const Waypoints& waypoints, const Path& path) {
  if (const auto row = FirstOutOfLimits(waypoints, path)) {
    return {.verdict = MotionVerdict::kOutOfLimits, .segment = static_cast<std::int32_t>(*row)};
  }
  MotionAnswer told;
  for (std::size_t k = 0; k + 1 < path.row_count && !checker.MustEnd(); ++k) {
    MotionAnswer edge = checker.Check(*waypoints.MotionFrom(path.first_row + k));
    if (edge.verdict != MotionVerdict::kFree) edge.segment = static_cast<std::int32_t>(k);
    if (edge.verdict == MotionVerdict::kContact || checker.ended()) return edge;
    const bool is_free =
        edge.verdict == MotionVerdict::kFree && told.verdict == MotionVerdict::kFree;
    if (is_free) told.clearance_m = std::min(told.clearance_m, edge.clearance_m);
    if (k == 0 || WeightOf(edge.verdict) > WeightOf(told.verdict)) told = edge;
  }
  return told;
}

}  // namespace

absl::StatusOr<MotionColumns> CheckPaths(const WorldSnapshot& world, const QueryBody& body,
                                         const Waypoints& waypoints, std::span<const Path> paths,
                                         const QueryOptions& options, std::stop_token stop) {
  if (auto status = EdgeChecker::CheckEngine(options); !status.ok()) return status;
  EdgeChecker checker(world, body, options, std::move(stop));
  MotionColumns columns;
  for (const Path& path : paths) {
    assert(path.row_count >= 2 && path.first_row + path.row_count <= waypoints.size());
    if (checker.MustEnd()) break;
    const MotionAnswer answer = Follow(checker, waypoints, path);
    if (checker.ended()) break;
    Append(columns, answer);
    ++columns.completed;
  }
  if (absl::Status status = checker.Finish(); !status.ok()) return status;
  while (columns.verdict.size() < paths.size()) Append(columns, {});
  return columns;
}

}  // namespace cwm::collision
