#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/pair_rows.h"
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

// The nearest pair of those that a walk visits, if within `limit_m`.
class NearestPair {
 public:
  explicit NearestPair(double limit_m) : limit_m_(limit_m) {}

  double reach_m() const { return std::max(0.0, limit_m_); }
  bool is_found() const { return is_found_; }
  const FoundPair& found() const { return found_; }

  double Add(const BodySearch::Pair& pair) {
    const PairDistance answer = pair.engine.Distance(pair.body, pair.object, limit_m_, pair.work);
    const bool nearer = !is_found_ || answer.distance_m < found_.answer.distance_m;
    if (answer.distance_m <= limit_m_ && nearer) {
      is_found_ = true;
      found_ = {.answer = answer, .id = pair.id};
      limit_m_ = answer.distance_m;
    }
    return reach_m();
  }

 private:
  double limit_m_;
  bool is_found_ = false;
  FoundPair found_;
};

void AddNearestOfObject(BodySearch& search, const Obstacle& object, double limit_m,
                        BestPairs& best) {
  NearestPair nearest(limit_m);
  search.ForEachPair(object, BodySearch::From::kSurface, nearest.reach_m(), Question::kDistance,
                     [&](const BodySearch::Pair& pair) { return nearest.Add(pair); });
  if (!nearest.is_found()) return;
  FoundPair found = nearest.found();
  const bool several = search.part_count() + object.parts_W.size() > 2;
  if (found.answer.distance_m < 0 && several) {
    LabelAsBound(search.body_bounds_W(), object.bounds_W, found.answer);
  }
  best.Add(found);
}

// Of parts that move apart by themselves: the depth of each pair is its own.
void AddNearestOfItself(BodySearch& search, double limit_m, BestPairs& best) {
  NearestPair nearest(limit_m);
  search.ForEachSelfPair(BodySearch::From::kSurface, nearest.reach_m(), Question::kDistance,
                         [&](const BodySearch::Pair& pair) { return nearest.Add(pair); });
  if (nearest.is_found()) best.Add(nearest.found());
}

void FindNearest(BodySearch& search, double max_distance_m, BestPairs& best) {
  best.Clear();
  const auto limit_m = [&] { return best.Limit_m(max_distance_m); };
  if (search.asks_itself()) AddNearestOfItself(search, limit_m(), best);
  if (!search.asks_world() || search.ended()) return;
  const auto visit = [&](const Obstacle& obstacle, double) {
    if (!search.Skips(obstacle)) AddNearestOfObject(search, obstacle, limit_m(), best);
    // Boxes that overlap are at distance 0 whatever the depth of what is in them.
    return search.ended() ? -1.0 : std::max(0.0, limit_m());
  };
  search.world().bounds().ForEachNearest(search.body_bounds_W(), std::max(0.0, limit_m()), visit);
}

class NearestFinder : public RowFinder {
 public:
  NearestFinder(BodySearch& search, const QueryOptions& options)
      : search_(search), max_distance_m_(options.max_distance_m), best_(options.max_results) {}

  const std::vector<FoundPair>& Find() override {
    FindNearest(search_, max_distance_m_, best_);
    return best_.pairs();
  }

 private:
  BodySearch& search_;
  const double max_distance_m_;
  BestPairs best_;
};

}  // namespace

absl::StatusOr<PairColumns> GetDistances(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options,
                                         std::stop_token stop) {
  return FindPairs({world, body, rows, options, std::move(stop)}, options.max_results,
                   [&](BodySearch& search) -> std::unique_ptr<RowFinder> {
                     return std::make_unique<NearestFinder>(search, options);
                   });
}

}  // namespace cwm::collision
