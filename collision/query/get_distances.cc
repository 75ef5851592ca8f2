#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "collision/query/body_search.h"
#include "collision/query/joint_gradients.h"
#include "collision/query/link_distances.h"
#include "collision/query/nearest_pair.h"
#include "collision/query/pair_columns.h"
#include "collision/query/pair_rows.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

void AddNearestOfObject(BodySearch& search, const Obstacle& object, double limit_m, double tie_m,
                        BestPairs& best) {
  NearestPair nearest(limit_m, tie_m);
  search.ForEachPairNearestFirst(object, nearest.reach_m(),
                                 [&](const BodySearch::Pair& pair) { return nearest.Add(pair); });
  if (!nearest.is_found()) return;
  FoundPair found = nearest.found();
  const bool several = search.part_count() + object.parts_W.size() > 2;
  if (found.answer.distance_m < 0 && several) {
    LabelAsBound(search.body_bounds_W(), object.bounds_W, found.answer);
  }
  best.Add(found);
}

// Adds the nearest self pair. Its depth needs no bound, since the two parts can move independently.
void AddNearestSelfPair(BodySearch& search, double limit_m, double tie_m, BestPairs& best) {
  NearestPair nearest(limit_m, tie_m);
  search.ForEachSelfPairNearestFirst(
      nearest.reach_m(), [&](const BodySearch::Pair& pair) { return nearest.Add(pair); });
  if (nearest.is_found()) best.Add(nearest.found());
}

// Visits the objects of a row ordered by the boxes of parts. The box around a whole robot would be
// of little use, since it is as wide as the robot's reach and contains most objects around it.
class NearestObjects {
 public:
  NearestObjects(BodySearch& search, double max_distance_m, double tie_m, BestPairs& best)
      : search_(search), max_distance_m_(max_distance_m), tie_m_(tie_m), best_(best) {}

  void Find() {
    queue_.clear();
    search_.world().bounds().ForEachNearest(search_.body_bounds_W(), reach_m(),
                                            [&](const Obstacle& obstacle, double min_m) {
                                              EvaluateWithin(min_m);
                                              if (search_.ended()) return -1.0;
                                              if (!search_.Skips(obstacle)) Await(obstacle);
                                              return reach_m();
                                            });
    EvaluateWithin(std::numeric_limits<double>::infinity());
  }

 private:
  struct QueueEntry {
    double squared_m2;  // squared gap
    const Obstacle* object;
    // Order for a heap that yields the nearest first, of equally near ones the first name.
    friend bool operator<(const QueueEntry& a, const QueueEntry& b) {
      return a.squared_m2 != b.squared_m2 ? a.squared_m2 > b.squared_m2
                                          : a.object->name > b.object->name;
    }
  };

  double limit_m() const { return best_.Limit_m(max_distance_m_); }
  // At least 0, since overlapping boxes have the gap 0 whatever the depth of their contents.
  double reach_m() const { return std::max(0.0, limit_m()); }

  void Await(const Obstacle& object) {
    queue_.push_back({search_.MinBoxDistance_m2(object), &object});
    std::push_heap(queue_.begin(), queue_.end());
  }

  // Tests the waiting objects whose gap is at most `min_m`, a lower bound for all objects to
  // come.
  void EvaluateWithin(double min_m) {
    while (!queue_.empty() && queue_.front().squared_m2 <= min_m * min_m && !search_.ended()) {
      const QueueEntry next = queue_.front();
      std::pop_heap(queue_.begin(), queue_.end());
      queue_.pop_back();
      if (next.squared_m2 > reach_m() * reach_m()) return queue_.clear();
      AddNearestOfObject(search_, *next.object, limit_m(), tie_m_, best_);
    }
  }

  BodySearch& search_;
  const double max_distance_m_;
  const double tie_m_;
  BestPairs& best_;
  std::vector<QueueEntry> queue_;
};

class NearestFinder : public RowFinder {
 public:
  NearestFinder(BodySearch& search, const QueryOptions& options, double tie_m)
      : search_(search),
        max_distance_m_(options.max_distance_m),
        tie_m_(tie_m),
        best_(options.max_results),
        objects_(search, max_distance_m_, tie_m, best_) {}

  const std::vector<FoundPair>& Find() override {
    best_.Clear();
    // Self pairs first: they can reduce the range of the search in the world.
    if (search_.tests_self()) {
      AddNearestSelfPair(search_, best_.Limit_m(max_distance_m_), tie_m_, best_);
    }
    if (search_.tests_world() && !search_.ended()) objects_.Find();
    return best_.pairs();
  }

 private:
  BodySearch& search_;
  const double max_distance_m_;
  const double tie_m_;
  BestPairs best_;
  NearestObjects objects_;
};

}  // namespace

absl::StatusOr<PairColumns> GetDistances(const WorldSnapshot& world, const QueryBody& body,
                                         const BodyRows& rows, const QueryOptions& options,
                                         std::stop_token stop) {
  const PairQuery query{world, body, rows, options, std::move(stop)};
  if (options.joint_gradients && JointRowsOf(query) == nullptr) {
    return absl::InvalidArgumentError("joint gradients are of a robot in states of its joints");
  }
  const double tie_m = options.joint_gradients ? kTieTolerance_m : 0;
  return FindPairs(query, std::max(1, options.max_results),
                   [&](BodySearch& search) -> std::unique_ptr<RowFinder> {
                     if (options.pairs == DistancePairs::kLinks) {
                       return MakeLinkPairFinder(search, options, tie_m);
                     }
                     return std::make_unique<NearestFinder>(search, options, tie_m);
                   });
}

}  // namespace cwm::collision
