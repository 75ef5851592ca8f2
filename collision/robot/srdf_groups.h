// The joints of the groups of an SRDF.
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

// The names of a robot, to resolve references.
struct RobotNames {
  std::map<std::string, int> links;
  std::map<std::string, int> joints;
  std::set<std::string> virtual_joints;
};

// Collects messages about elements with unknown names, and others that cannot be used.
class SkippedElements {
 public:
  void Add(std::string what);
  // True, with the message added, if the status is NotFound, the error of Unknown.
  bool AddIfUnknown(const absl::Status& status);
  // At most kMaxLeftOut messages, and a line with the number of further ones.
  std::vector<std::string> Lines() const;

 private:
  std::vector<std::string> lines_;
  std::size_t more_ = 0;
};

// A NotFound error for an element with an unknown name, worded like XmlElement::FaultOf.
absl::Status Unknown(const XmlElement& element, const char* attribute, std::string_view rule);

// The index of the link that an attribute names; Unknown if the robot does not have it.
absl::StatusOr<int> LinkAt(const XmlElement& element, const char* attribute,
                           const RobotNames& names);
// The index of the joint that an attribute names; empty for a virtual joint.
absl::StatusOr<std::optional<int>> JointAt(const XmlElement& element, const char* attribute,
                                           const RobotNames& names);

// Reads <group> elements in order, leaving out unknown members. CANCELLED after `stop` was
// requested.
absl::StatusOr<std::vector<SemanticGroup>> ReadGroups(const std::vector<XmlElement>& elements,
                                                      const RobotDescription& robot,
                                                      const KinematicTree& tree,
                                                      const RobotNames& names,
                                                      SkippedElements& left_out,
                                                      const std::stop_token& stop);

}  // namespace cwm::collision
