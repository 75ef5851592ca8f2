#include "collision/world/world_snapshot.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <utility>

namespace cwm::collision {
namespace {

BoundsTree<Obstacle> TreeOver(std::span<const WorldObjectPtr> objects,
                              const std::vector<WorldRobotPtr>& robots) {
  std::vector<const Obstacle*> items;
  items.reserve(objects.size() + robots.size());
  for (const WorldObjectPtr& object : objects) items.push_back(object.get());
  for (const WorldRobotPtr& robot : robots) items.push_back(&robot->body);
  return BoundsTree<Obstacle>(items);
}

bool IsAttached(const WorldObjectPtr& object) {
  return object != nullptr && object->attachment != nullptr;
}

bool HidesSpace(const WorldObjectPtr& object) {
  return object != nullptr && object->geometry->max_hidden_m > 0;
}

bool HasCappedMesh(const WorldObjectPtr& object) {
  return object != nullptr && object->geometry->has_caps;
}

using Objects = std::vector<WorldObjectPtr>;

template <class Predicate>
std::shared_ptr<const Objects> Filtered(std::span<const WorldObjectPtr> objects,
                                        const Predicate& predicate) {
  Objects filtered;
  std::copy_if(objects.begin(), objects.end(), std::back_inserter(filtered), predicate);
  return std::make_shared<const Objects>(std::move(filtered));
}

// The objects of a predicate, ordered by name, after the deltas.
template <class Predicate>
std::shared_ptr<const Objects> FilteredAfter(std::shared_ptr<const Objects> filtered,
                                             std::span<const ObjectDelta> deltas,
                                             const Predicate& predicate) {
  const bool is_same = std::none_of(deltas.begin(), deltas.end(), [&](const auto& delta) {
    return predicate(delta.before) || predicate(delta.after);
  });
  if (is_same) return filtered;
  Objects after(*filtered);
  for (const ObjectDelta& delta : deltas) {
    if (predicate(delta.before)) std::erase(after, delta.before);
    if (predicate(delta.after)) after.push_back(delta.after);
  }
  std::sort(after.begin(), after.end(),
            [](const WorldObjectPtr& a, const WorldObjectPtr& b) { return a->name < b->name; });
  return std::make_shared<const Objects>(std::move(after));
}

// The first robot whose name is not less.
auto LowerBound(const std::vector<WorldRobotPtr>& robots, std::string_view name) {
  return std::lower_bound(
      robots.begin(), robots.end(), name,
      [](const WorldRobotPtr& robot, std::string_view n) { return robot->name < n; });
}

bool Holds(const std::vector<WorldRobotPtr>& robots, std::vector<WorldRobotPtr>::const_iterator at,
           std::string_view name) {
  return at != robots.end() && (*at)->name == name;
}

std::vector<WorldRobotPtr> RobotsAfter(std::vector<WorldRobotPtr> robots,
                                       std::span<const RobotDelta> deltas) {
  for (const auto& [before, after] : deltas) {
    const std::string& name = (after != nullptr ? after : before)->name;
    auto at = LowerBound(robots, name);
    if (Holds(robots, at, name)) at = robots.erase(at);
    if (after != nullptr) robots.insert(at, after);
  }
  return robots;
}

}  // namespace

WorldSnapshot::WorldSnapshot(Revision revision, std::span<const WorldObjectPtr> objects_by_name,
                             std::vector<WorldRobotPtr> robots_by_name, PairRules pair_rules)
    : revision_(revision),
      objects_(objects_by_name),
      bounds_(TreeOver(objects_by_name, robots_by_name)),
      attached_(Filtered(objects_by_name, IsAttached)),
      with_hidden_(Filtered(objects_by_name, HidesSpace)),
      with_caps_(Filtered(objects_by_name, HasCappedMesh)),
      robots_(std::make_shared<const Robots>(std::move(robots_by_name))),
      pair_rules_(std::make_shared<const PairRules>(std::move(pair_rules))) {
  [[maybe_unused]] const auto precedes = [](const auto& a, const auto& b) {
    return a->name < b->name;
  };
  assert(std::is_sorted(objects_by_name.begin(), objects_by_name.end(), precedes));
  assert(std::is_sorted(robots_->begin(), robots_->end(), precedes));
  for (const WorldObjectPtr& object : objects_by_name) weight_ += object->geometry->weight;
  for (const WorldRobotPtr& robot : *robots_) weight_ += robot->body.geometry->weight;
}

WorldSnapshot WorldSnapshot::After(Revision revision, std::span<const ObjectDelta> deltas,
                                   std::span<const RobotDelta> robot_deltas,
                                   std::shared_ptr<const PairRules> pair_rules,
                                   WorkCounter* work) const {
  constexpr std::size_t kStepsPerDelta = 256;  // some microseconds
  WorldSnapshot next = *this;
  next.revision_ = revision;
  for (const auto& [before, after] : deltas) {
    if (MustEnd(work, kStepsPerDelta)) return next;
    if (before != nullptr) {
      next.bounds_ = next.bounds_.Without(*before);
      next.weight_ -= before->geometry->weight;
    }
    if (after != nullptr) {
      next.weight_ += after->geometry->weight;
      next.bounds_ = next.bounds_.With(*after);
      next.objects_ = next.objects_.With(after);
    } else {
      next.objects_ = next.objects_.Without(before->name);
    }
  }
  next.attached_ = FilteredAfter(attached_, deltas, IsAttached);
  next.with_hidden_ = FilteredAfter(with_hidden_, deltas, HidesSpace);
  next.with_caps_ = FilteredAfter(with_caps_, deltas, HasCappedMesh);
  for (const auto& [before, after] : robot_deltas) {
    if (before != nullptr) {
      next.bounds_ = next.bounds_.Without(before->body);
      next.weight_ -= before->body.geometry->weight;
    }
    if (after != nullptr) {
      next.bounds_ = next.bounds_.With(after->body);
      next.weight_ += after->body.geometry->weight;
    }
  }
  if (!robot_deltas.empty()) {
    next.robots_ = std::make_shared<const Robots>(RobotsAfter(*robots_, robot_deltas));
  }
  if (pair_rules != nullptr) next.pair_rules_ = std::move(pair_rules);
  return next;
}

WorldObjectPtr WorldSnapshot::Find(std::string_view name) const {
  const WorldObjectPtr* object = objects_.Find(name);
  return object != nullptr ? *object : nullptr;
}

bool WorldSnapshot::has_caps() const {
  return !with_caps_->empty() || std::ranges::any_of(*robots_, [](const WorldRobotPtr& robot) {
    return robot->body.geometry->has_caps;
  });
}

double WorldSnapshot::max_margin_m() const {
  double max_m = objects_.max_margin_m();
  for (const WorldRobotPtr& robot : *robots_) {
    for (const double padding_m : PaddingsOf_m(robot->body)) max_m = std::max(max_m, padding_m);
  }
  return max_m;
}

const Obstacle& WorldSnapshot::ObstacleAt(std::size_t index) const {
  if (index < objects_.size()) return *objects_[index];
  return (*robots_)[index - objects_.size()]->body;
}

std::size_t WorldSnapshot::IndexOf(const Obstacle& obstacle) const {
  if (obstacle.robot == nullptr) return *objects_.RankOf(obstacle.name);
  const auto rank = LowerBound(*robots_, obstacle.name) - robots_->begin();
  return objects_.size() + static_cast<std::size_t>(rank);
}

std::size_t WorldSnapshot::RankByName(const Obstacle& obstacle) const {
  const auto robots_before =
      static_cast<std::size_t>(LowerBound(*robots_, obstacle.name) - robots_->begin());
  if (obstacle.robot == nullptr) return *objects_.RankOf(obstacle.name) + robots_before;
  std::size_t first = 0, last = objects_.size();  // the number of objects with a lesser name
  while (first < last) {
    const std::size_t middle = first + (last - first) / 2;
    if (objects_[middle]->name < obstacle.name) {
      first = middle + 1;
    } else {
      last = middle;
    }
  }
  return first + robots_before;
}

WorldRobotPtr WorldSnapshot::FindRobot(std::string_view name) const {
  const auto at = LowerBound(*robots_, name);
  return Holds(*robots_, at, name) ? *at : nullptr;
}

std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after) {
  return ObjectTable::Difference(before.objects(), after.objects());
}

std::vector<RobotDelta> RobotDifference(const WorldSnapshot& before, const WorldSnapshot& after) {
  std::vector<RobotDelta> deltas;
  if (&before.robots() == &after.robots()) return deltas;
  auto a = before.robots().begin(), b = after.robots().begin();
  const auto a_end = before.robots().end(), b_end = after.robots().end();
  while (a != a_end || b != b_end) {
    if (b == b_end || (a != a_end && (*a)->name < (*b)->name)) {
      deltas.push_back({.before = *a++, .after = nullptr});
    } else if (a == a_end || (*b)->name < (*a)->name) {
      deltas.push_back({.before = nullptr, .after = *b++});
    } else if (!(*a)->IsSameAs(**b)) {
      deltas.push_back({.before = *a++, .after = nullptr});
      deltas.push_back({.before = nullptr, .after = *b++});
    } else {
      if (*a != *b) deltas.push_back({.before = *a, .after = *b});
      ++a, ++b;
    }
  }
  return deltas;
}

}  // namespace cwm::collision
