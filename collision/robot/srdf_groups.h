// Which joints the groups of an SRDF hold.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
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

// Elements that name what there is not, and others that cannot be taken.
class LeftOut {
 public:
  void Add(std::string what);
  // Notes it where the status is of such an element: NotFound.
  bool Takes(const absl::Status& status);
  // At most kMostLeftOut, and how many more there are.
  std::vector<std::string> Lines() const;

 private:
  std::vector<std::string> lines_;
  std::size_t more_ = 0;
};

// NotFound, of an element that names what there is not, in the words of XmlElement::FaultOf.
absl::Status Unknown(const XmlElement& element, const char* attribute, std::string_view rule);

// The name in an attribute, which must be a link of the robot, or it is Unknown; its index.
absl::StatusOr<int> LinkAt(const XmlElement& element, const char* attribute,
                           const RobotNames& names);
// The same of a joint; nothing for a virtual one.
absl::StatusOr<std::optional<int>> JointAt(const XmlElement& element, const char* attribute,
                                           const RobotNames& names);

// Reads <group> elements, in their order, but for members that are unknown. CANCELLED after `stop` was
// requested.
absl::StatusOr<std::vector<SemanticGroup>> ReadGroups(const std::vector<XmlElement>& elements,
                                                      const RobotDescription& robot,
                                                      const KinematicTree& tree,
                                                      const RobotNames& names, LeftOut& left_out,
                                                      const std::stop_token& stop);

}  // namespace cwm::collision
