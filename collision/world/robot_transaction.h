// The robots of a world while a list of changes is applied.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// The robots that a list touches, over an untouched base, which outlives it.
class RobotTransaction {
 public:
  explicit RobotTransaction(const WorldSnapshot& base)
      : base_(base), revision_{base.revision().value + 1} {}

  // Whether the name is free of objects is the caller's to know.
  absl::Status Put(const PutRobot& put);
  absl::Status Remove(const RemoveRobot& remove);
  absl::Status Set(const SetRobotState& set);

  bool Has(const std::string& name) const { return Current(name) != nullptr; }
  // The robot as the list has left it so far, with its links placed; nullptr when there is none.
  // Valid until the next change of that robot.
  const WorldRobot* Current(const std::string& name) const;

  // What has an effect, ordered by name.
  std::vector<RobotDelta> Finish();

 private:
  void Touch(WorldRobot robot);

  const WorldSnapshot& base_;
  Revision revision_;
  std::map<std::string, std::optional<WorldRobot>, std::less<>> touched_;  // nullopt: removed
};

// What the world and the trees over it rely on: finite, in range, a proper rotation.
bool IsPlaceable(const Pose& X_WO);

}  // namespace cwm::collision
