// How the links of a description hang together.
#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"

namespace cwm::collision {

// Links and joints are indices into a description.
struct KinematicTree {
  // Every link after its parent; among those that may come next, the earlier in the description.
  // A description that lists parents first keeps its order.
  std::vector<int> order;
  std::vector<std::optional<int>> joint_of;   // by link: the joint it hangs on; none for the root
  std::vector<std::optional<int>> parent_of;  // by link: the link above
};

// Refuses what is no tree: no links, duplicate or unknown names, a link on two joints, several
// roots, cycles.
absl::StatusOr<KinematicTree> MakeKinematicTree(const RobotDescription& robot);

}  // namespace cwm::collision
