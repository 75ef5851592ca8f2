#include <cmath>
#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

// The least translation along an axis of the world that parts two overlapping boxes: no depth
// within them is greater.
double LeastSeparation_m(const Aabb& a, const Aabb& b) {
  return (a.max() - b.min()).cwiseMin(b.max() - a.min()).minCoeff();
}

// Of several parts the deepest tells; the depth of the whole is at least that.
void LabelAsBound(const Aabb& body_W, const Aabb& object_W, PairDistance& answer) {
  const double most_m = LeastSeparation_m(body_W, object_W);
  if (!std::isfinite(most_m)) {  // a tilted half-space has no bounds
    answer.trust = Trust::kDegraded;
    return;
  }
  answer.trust = std::max(answer.trust, Trust::kBounded);
  answer.bound_m += std::max(0.0, most_m + answer.distance_m);
}

// The nearest pair of parts of the body and one object, if within `limit_m`.
std::optional<FoundPair> NearestPair(BodySearch& search, const WorldObject& object, double limit_m,
                                     std::size_t body_part_count) {
  std::optional<FoundPair> nearest;
  search.ForEachPair(
      object, std::max(0.0, limit_m), Question::kDistance, [&](const BodySearch::Pair& pair) {
        const PairDistance answer = pair.engine.Distance(pair.body, pair.object, limit_m);
        const bool nearer = !nearest.has_value() || answer.distance_m < nearest->answer.distance_m;
        if (answer.distance_m <= limit_m && nearer) {
          nearest = FoundPair{.answer = answer, .id = pair.id};
          limit_m = answer.distance_m;
        }
        return std::max(0.0, limit_m);
      });
  const bool several = body_part_count + object.parts_W.size() > 2;
  if (nearest.has_value() && nearest->answer.distance_m < 0 && several) {
    LabelAsBound(search.body_bounds_W(), object.bounds_W, nearest->answer);
  }
  return nearest;
}

}  // namespace

absl::StatusOr<PairColumns> GetDistances(const WorldSnapshot& world, const QueryBody& body,
                                         std::span<const Pose> X_WB, const QueryOptions& options,
                                         std::stop_token stop) {
  BodySearch search(world, body, options, std::move(stop));
  const std::size_t body_part_count = body.geometry->parts.size();
  BestPairs best(options.max_results);
  ObjectRanks ranks(world);
  PairColumns columns;
  Reserve(columns, X_WB.size(), std::max(0, options.max_results));
  for (const Pose& X : X_WB) {
    if (search.MustEnd()) break;
    search.PlaceBody(X);
    best.Clear();
    const auto limit_m = [&] { return best.Limit_m(options.max_distance_m); };
    world.bounds().ForEachNearest(
        search.body_bounds_W(), std::max(0.0, limit_m()), [&](const WorldObject& object, double) {
          if (search.Skips(object)) return std::max(0.0, limit_m());
          const auto nearest = NearestPair(search, object, limit_m(), body_part_count);
          if (nearest.has_value()) best.Add(*nearest);
          // Boxes that overlap are at distance 0 whatever the depth of what is in them.
          return search.ended() ? -1.0 : std::max(0.0, limit_m());
        });
    if (search.ended()) break;
    AppendRow(columns, best.pairs(), ranks);
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  return columns;
}

}  // namespace cwm::collision
