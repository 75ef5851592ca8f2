// The robots of a world while a list of changes is applied.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// The robots that a list touches, over an unchanged base, which must outlive this object.
class RobotTransaction {
 public:
  explicit RobotTransaction(const WorldSnapshot& base)
      : base_(base), revision_{base.revision().value + 1} {}

  // The caller ensures that no object has the name.
  absl::Status Put(const PutRobot& put);
  absl::Status Remove(const RemoveRobot& remove);
  absl::Status Set(const SetRobotState& set);

  bool Has(const std::string& name) const { return Current(name) != nullptr; }
  // The robot after the changes so far, with its links placed; nullptr if there is none. Valid
  // until the next change of that robot.
  const WorldRobot* Current(const std::string& name) const;

  // The changes that have an effect, ordered by name.
  std::vector<RobotDelta> Finish();

 private:
  void Touch(WorldRobot robot);

  const WorldSnapshot& base_;
  Revision revision_;
  std::map<std::string, std::optional<WorldRobot>, std::less<>> touched_;  // nullopt: removed
};

// True if a pose may be in a world: finite, in range, a proper rotation.
bool IsPlaceable(const Pose& X_WO);

}  // namespace cwm::collision
