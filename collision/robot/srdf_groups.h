// Which joints the groups of an SRDF hold.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/kinematic_tree.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/srdf.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {

// The names of a robot, for what refers to them.
struct RobotNames {
  std::map<std::string, int> links;
  std::map<std::string, int> joints;
  std::set<std::string> virtual_joints;
};

// The name in an attribute, which must be a link of the robot; its index.
absl::StatusOr<int> LinkAt(const XmlElement& element, const char* attribute,
                           const RobotNames& names);
// The same of a joint; nothing for a virtual one.
absl::StatusOr<std::optional<int>> JointAt(const XmlElement& element, const char* attribute,
                                           const RobotNames& names);

// Reads <group> elements, in their order.
absl::StatusOr<std::vector<SemanticGroup>> ReadGroups(const std::vector<XmlElement>& elements,
                                                      const RobotDescription& robot,
                                                      const KinematicTree& tree,
                                                      const RobotNames& names);

}  // namespace cwm::collision
