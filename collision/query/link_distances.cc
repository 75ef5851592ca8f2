#include "collision/query/link_distances.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "collision/query/nearest_pair.h"

namespace cwm::collision {
namespace {

// Finds the nearest pair of each group, and keeps the nearest groups of each frame.
class LinkPairFinder : public RowFinder {
 public:
  LinkPairFinder(BodySearch& search, const QueryOptions& options, double tie_m)
      : search_(search),
        max_distance_m_(options.max_distance_m),
        max_results_(options.max_results),
        max_answers_(options.max_answers),
        tie_m_(tie_m) {
    for (std::size_t part = 0; part < search.part_count(); ++part) {
      const auto frame = static_cast<std::size_t>(search.FrameOf(static_cast<std::int32_t>(part)));
      part_counts_.resize(std::max(part_counts_.size(), frame + 1), 0);
      ++part_counts_[frame];
    }
    best_.assign(part_counts_.size(), BestPairs(max_results_));
  }

  const std::vector<FoundPair>& Find() override {
    found_.clear();
    for (BestPairs& best : best_) best.Clear();
    if (search_.tests_self()) FindSelfPairs();
    if (search_.tests_world() && !search_.ended()) FindWorldPairs();
    for (const BestPairs& best : best_) {
      found_.insert(found_.end(), best.pairs().begin(), best.pairs().end());
    }
    const auto comes_first = [&](const FoundPair& a, const FoundPair& b) {
      const int of_a = search_.FrameOf(a.id.body_part), of_b = search_.FrameOf(b.id.body_part);
      return of_a != of_b ? of_a < of_b : a < b;
    };
    std::ranges::sort(found_, comes_first);
    return found_;
  }

 private:
  using Group = BodySearch::Group;

  bool keeps_all() const { return max_results_ == 0; }
  // The largest distance at which a further group of the frame is kept.
  double Limit_m(int frame) const {
    if (keeps_all()) return max_distance_m_;
    return best_[static_cast<std::size_t>(frame)].Limit_m(max_distance_m_);
  }

  void FindSelfPairs() {
    search_.ForEachSelfGroupNearestFirst(
        max_distance_m_ + tie_m_, [&](const Group& group) { return Begin(nullptr, group); },
        [&](const BodySearch::Pair& pair) { return nearest_->Add(pair); });
    End();
  }

  void FindWorldPairs() {
    search_.world().bounds().ForEachNearest(
        search_.body_bounds_W(), WorldReach_m(), [&](const Obstacle& obstacle, double) {
          if (!search_.Skips(obstacle)) FindPairsWith(obstacle);
          return search_.ended() || found_.size() > max_answers_ ? -1.0 : WorldReach_m();
        });
  }

  void FindPairsWith(const Obstacle& obstacle) {
    search_.ForEachGroupNearestFirst(
        obstacle, WorldReach_m(), [&](const Group& group) { return Begin(&obstacle, group); },
        [&](const BodySearch::Pair& pair) { return nearest_->Add(pair); });
    End();
  }

  // The reach within which an obstacle can still add an answer to some frame.
  double WorldReach_m() const {
    if (keeps_all()) return max_distance_m_ + tie_m_;
    double limit_m = -std::numeric_limits<double>::infinity();
    for (std::size_t part = 0; part < search_.part_count(); ++part) {
      const auto k = static_cast<std::int32_t>(part);
      if (search_.TestsWorld(k)) limit_m = std::max(limit_m, Limit_m(search_.FrameOf(k)));
    }
    return std::max(0.0, limit_m) + tie_m_;
  }

  // Begins a group, which ends the one before.
  double Begin(const Obstacle* obstacle, const Group& group) {
    End();
    obstacle_ = obstacle;
    group_ = group;
    nearest_.emplace(Limit_m(group.frame), tie_m_);
    return nearest_->reach_m();
  }

  void End() {
    if (nearest_ && nearest_->is_found()) {
      FoundPair found = nearest_->found();
      if (found.answer.distance_m < 0 && HasSeveralPairs()) {
        LabelAsBound(BoundsOfFrame_W(group_.frame), OtherBounds_W(), found.answer);
      }
      if (keeps_all()) {
        found_.push_back(found);
      } else {
        best_[static_cast<std::size_t>(group_.frame)].Add(found);
      }
    }
    nearest_.reset();
  }

  bool HasSeveralPairs() const {
    const auto count_of = [&](int frame) { return part_counts_[static_cast<std::size_t>(frame)]; };
    std::size_t others = 0;
    if (obstacle_ == nullptr) {
      others = count_of(group_.other);
    } else if (obstacle_->robot == nullptr) {
      others = obstacle_->parts_W.size();
    } else {
      others = static_cast<std::size_t>(
          std::ranges::count(obstacle_->robot->link_of_part, group_.other));
    }
    return count_of(group_.frame) * others > 1;
  }

  Aabb BoundsOfFrame_W(int frame) const {
    Aabb bounds_W;
    for (std::size_t part = 0; part < search_.part_count(); ++part) {
      const auto k = static_cast<std::int32_t>(part);
      if (search_.FrameOf(k) == frame) bounds_W.extend(search_.BoundsOf_W(k));
    }
    return bounds_W;
  }

  Aabb OtherBounds_W() const {
    if (obstacle_ == nullptr) return BoundsOfFrame_W(group_.other);
    if (obstacle_->robot == nullptr) return obstacle_->bounds_W;
    Aabb bounds_W;
    for (std::size_t part = 0; part < obstacle_->parts_W.size(); ++part) {
      if (obstacle_->robot->link_of_part[part] != group_.other) continue;
      bounds_W.extend(obstacle_->parts_W[part].bounds_W);
    }
    return bounds_W;
  }

  BodySearch& search_;
  const double max_distance_m_;
  const int max_results_;
  const std::size_t max_answers_;
  const double tie_m_;
  std::vector<std::size_t> part_counts_;  // by frame
  std::vector<BestPairs> best_;           // by frame
  std::vector<FoundPair> found_;
  // The group that is searched.
  const Obstacle* obstacle_ = nullptr;  // nullptr: the body itself
  Group group_;
  std::optional<NearestPair> nearest_;
};

}  // namespace

std::unique_ptr<RowFinder> MakeLinkPairFinder(BodySearch& search, const QueryOptions& options,
                                              double tie_m) {
  return std::make_unique<LinkPairFinder>(search, options, tie_m);
}

}  // namespace cwm::collision
