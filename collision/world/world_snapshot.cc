#include "collision/world/world_snapshot.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cwm::collision {
namespace {

BoundsTree<WorldObject> TreeOver(std::span<const WorldObjectPtr> objects) {
  std::vector<const WorldObject*> items;
  items.reserve(objects.size());
  for (const WorldObjectPtr& object : objects) items.push_back(object.get());
  return BoundsTree<WorldObject>(items);
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
      bounds_(TreeOver(objects_by_name)),
      robots_(std::make_shared<const Robots>(std::move(robots_by_name))),
      pair_rules_(std::make_shared<const PairRules>(std::move(pair_rules))) {
  [[maybe_unused]] const auto precedes = [](const auto& a, const auto& b) {
    return a->name < b->name;
  };
  assert(std::is_sorted(objects_by_name.begin(), objects_by_name.end(), precedes));
  assert(std::is_sorted(robots_->begin(), robots_->end(), precedes));
}

WorldSnapshot WorldSnapshot::After(Revision revision, std::span<const ObjectDelta> deltas,
                                   std::span<const RobotDelta> robot_deltas,
                                   std::shared_ptr<const PairRules> pair_rules) const {
  WorldSnapshot next = *this;
  next.revision_ = revision;
  for (const auto& [before, after] : deltas) {
    if (before != nullptr) next.bounds_ = next.bounds_.Without(*before);
    if (after != nullptr) {
      next.bounds_ = next.bounds_.With(*after);
      next.objects_ = next.objects_.With(after);
    } else {
      next.objects_ = next.objects_.Without(before->name);
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
    } else if ((*a)->uid != (*b)->uid) {
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
