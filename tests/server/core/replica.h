// A copy of a world maintained by a watch: the oracle of watch tests. Checks each step.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "collision/world/world_snapshot.h"
#include "server/core/watch.h"

namespace cwm::server {

class Replica {
 public:
  Replica() = default;
  explicit Replica(const collision::WorldSnapshot& start) { Reset(start); }

  // Reads until there is nothing more; returns the status that ended the watch, if any.
  absl::Status ReadAll(WatchCursor& watch) {
    while (true) {
      const auto step = watch.Next();
      if (!step.ok()) return step.status();
      if (!step->has_value()) return absl::OkStatus();
      Take(**step);
      EXPECT_EQ(watch.position(), revision_);
    }
  }

  void Take(const WatchStep& step) {
    if (step.kind == WatchStep::Kind::kInitialState) {
      Reset(*step.snapshot);
      return;
    }
    if (step.kind == WatchStep::Kind::kEvents || !step.last) {
      EXPECT_GT(step.revision, revision_) << "ordered and unique";
    }
    revision_ = step.revision;
    TakeDeltas(step.deltas, objects_);
    TakeDeltas(step.robot_deltas, robots_);
    for (const collision::PairRuleDelta& delta : step.rule_deltas) {
      const collision::PairRule* before = FindRule(rules_, delta.before.pair);
      EXPECT_EQ(before != nullptr ? *before : collision::PairRule{.pair = delta.before.pair},
                delta.before)
          << "no event between was lost";
      SetRule(rules_, delta.after);
    }
  }

  collision::Revision revision() const { return revision_; }
  std::vector<collision::WorldObjectPtr> objects() const {
    std::vector<collision::WorldObjectPtr> objects;
    for (const auto& [name, object] : objects_) objects.push_back(object);
    return objects;
  }
  std::vector<collision::WorldRobotPtr> robots() const {
    std::vector<collision::WorldRobotPtr> robots;
    for (const auto& [name, robot] : robots_) robots.push_back(robot);
    return robots;
  }
  const collision::PairRules& rules() const { return rules_; }

 private:
  // For deltas of objects or robots.
  template <class Delta, class Ptr>
  static void TakeDeltas(const std::vector<Delta>& deltas, std::map<std::string, Ptr>& members) {
    std::string previous;
    for (const Delta& delta : deltas) {
      const std::string& name = (delta.before ? delta.before : delta.after)->name;
      EXPECT_TRUE(previous < name || (previous == name && delta.before == nullptr))
          << "one delta a member, by name; two where it was made anew: " << name;
      previous = name;
      const auto found = members.find(name);
      const auto before = found == members.end() ? nullptr : found->second;
      EXPECT_EQ(before, delta.before) << "no event between was lost: " << name;
      if (delta.after == nullptr) {
        members.erase(name);
      } else {
        members[name] = delta.after;
      }
    }
  }

  void Reset(const collision::WorldSnapshot& snapshot) {
    revision_ = snapshot.revision();
    objects_.clear();
    for (const auto& object : snapshot.objects()) objects_[object->name] = object;
    robots_.clear();
    for (const auto& robot : snapshot.robots()) robots_[robot->name] = robot;
    rules_ = snapshot.pair_rules();
  }

  collision::Revision revision_;
  std::map<std::string, collision::WorldObjectPtr> objects_;
  std::map<std::string, collision::WorldRobotPtr> robots_;
  collision::PairRules rules_;
};

}  // namespace cwm::server
