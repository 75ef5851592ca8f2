// The tree of links and joints of a description.
#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"

namespace cwm::collision {

// Links and joints are indices into a description.
struct KinematicTree {
  // Links such that each comes after its parent. Of several candidates, the one that is earlier in
  // the description comes first, so that a description with parents first keeps its order.
  std::vector<int> order;
  std::vector<std::optional<int>> joint_of;   // by link: the joint above it; none for the root
  std::vector<std::optional<int>> parent_of;  // by link: the link above it
};

// Builds the tree. Refuses descriptions without links, duplicate or unknown names, links below two
// joints, several roots, and cycles.
absl::StatusOr<KinematicTree> MakeKinematicTree(const RobotDescription& robot);

}  // namespace cwm::collision
