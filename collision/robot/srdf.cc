#include "collision/robot/srdf.h"

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/robot/kinematic_tree.h"
#include "collision/robot/srdf_groups.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

class SrdfReader {
 public:
  SrdfReader(const RobotDescription& robot, const RobotLimits& limits, std::stop_token stop)
      : robot_(robot), limits_(limits), stop_(std::move(stop)) {}

  absl::StatusOr<SemanticDescription> Read(const XmlElement& root) {
    if (root.tag() != "robot") {
      return root.Fault(
          absl::StrCat("has the root element <", std::string(root.tag()), ">, must have <robot>"));
    }
    const absl::StatusOr<KinematicTree> tree = MakeKinematicTree(robot_);
    if (!tree.ok()) return tree.status();
    NameRobot();
    // Elements that define names are read before those that refer to them.
    absl::Status status = ForEach(root, "virtual_joint", &SrdfReader::AddVirtualJoint);
    if (status.ok()) status = AddGroups(root.Children("group"), *tree);
    if (status.ok()) status = ForEach(root, "group_state", &SrdfReader::AddState);
    if (status.ok()) status = ForEach(root, "end_effector", &SrdfReader::AddEndEffector);
    if (status.ok()) status = ForEach(root, "passive_joint", &SrdfReader::AddPassiveJoint);
    if (status.ok()) status = ForEach(root, "disable_collisions", &SrdfReader::AddDisabledPair);
    if (status.ok()) status = ForEach(root, "enable_collisions", &SrdfReader::AddEnabledPair);
    if (status.ok()) {
      status = ForEach(root, "disable_default_collisions", &SrdfReader::AddDisabledLink);
    }
    if (!status.ok()) return status;
    semantic_.left_out = left_out_.Lines();
    WarnOfMismatch(root);
    return std::move(semantic_);
  }

 private:
  using Adder = absl::Status (SrdfReader::*)(const XmlElement&);

  // Reports signs that the file is not the one that the user meant.
  void WarnOfMismatch(const XmlElement& root) {
    std::vector<std::string>& lines = semantic_.left_out;
    if (lines.empty() && semantic_.groups.empty() && semantic_.disabled_pairs.empty() &&
        semantic_.disabled_links.empty()) {
      lines.emplace_back("srdf: has neither groups nor pairs of links that are not checked");
    }
    const absl::StatusOr<std::string> name = root.Text("name");
    if (root.Has("name") && name.ok() && *name != robot_.name) {
      lines.insert(lines.begin(), absl::StrCat("srdf: is of the robot \"", *name,
                                               "\", the URDF is of \"", robot_.name, "\""));
    }
  }

  absl::Status ForEach(const XmlElement& root, const char* tag, Adder add) {
    for (const XmlElement& element : root.Children(tag)) {
      if (stop_.stop_requested()) return absl::CancelledError();
      const absl::Status status = (this->*add)(element);
      if (!status.ok() && !left_out_.AddIfUnknown(status)) return status;
    }
    return absl::OkStatus();
  }

  void NameRobot() {
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      names_.links.emplace(robot_.links[i].name, static_cast<int>(i));
    }
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      names_.joints.emplace(robot_.joints[i].name, static_cast<int>(i));
    }
  }

  absl::Status AddVirtualJoint(const XmlElement& element) {
    VirtualJoint joint;
    const absl::StatusOr<std::string> name = element.Name("name");
    if (!name.ok()) return name.status();
    joint.name = *name;
    if (names_.joints.count(*name) > 0 || names_.virtual_joints.count(*name) > 0) {
      return element.Fault("must not have the name of another joint");
    }
    const absl::StatusOr<std::string> type = element.Text("type");
    if (!type.ok()) return type.status();
    if (*type != "fixed" && *type != "planar" && *type != "floating") {
      return element.FaultOf("type", "must be fixed, planar or floating");
    }
    joint.type = *type;
    const absl::StatusOr<std::string> frame = element.Name("parent_frame");
    if (!frame.ok()) return frame.status();
    joint.parent_frame = *frame;
    const absl::StatusOr<int> child = LinkAt(element, "child_link", names_);
    if (!child.ok()) return child.status();
    joint.child_link = robot_.links[*child].name;
    names_.virtual_joints.insert(*name);
    semantic_.virtual_joints.push_back(std::move(joint));
    return absl::OkStatus();
  }

  absl::Status AddGroups(const std::vector<XmlElement>& elements, const KinematicTree& tree) {
    if (elements.size() > static_cast<std::size_t>(limits_.max_groups)) {
      return ExcessAt("srdf", absl::StrCat("has ", elements.size(), " groups, must have at most ",
                                           limits_.max_groups));
    }
    absl::StatusOr<std::vector<SemanticGroup>> groups =
        ReadGroups(elements, robot_, tree, names_, left_out_, stop_);
    if (!groups.ok()) return groups.status();
    semantic_.groups = *std::move(groups);
    for (const SemanticGroup& group : semantic_.groups) groups_.insert(group.name);
    return absl::OkStatus();
  }

  absl::StatusOr<std::string> GroupAt(const XmlElement& element, const char* attribute) const {
    const absl::StatusOr<std::string> name = element.Text(attribute);
    if (name.ok() && groups_.count(*name) == 0) {
      return Unknown(element, attribute, "must be a group of the SRDF");
    }
    return name;
  }

  absl::Status AddState(const XmlElement& element) {
    if (states_.size() == static_cast<std::size_t>(limits_.max_states)) {
      return ExcessAt("srdf", absl::StrCat("has more than ", limits_.max_states,
                                           " named states, must have at most so many"));
    }
    SemanticState state;
    const absl::StatusOr<std::string> name = element.Name("name");
    if (!name.ok()) return name.status();
    const absl::StatusOr<std::string> group = GroupAt(element, "group");
    if (!group.ok()) return group.status();
    if (!states_.emplace(*group, *name).second) {
      return element.Fault("must not appear twice for a group");
    }
    state.name = *name;
    state.group = *group;
    for (const XmlElement& joint : element.Children("joint")) {
      if (stop_.stop_requested()) return absl::CancelledError();
      const absl::Status status = AddPosition(joint, state);
      if (!status.ok() && !left_out_.AddIfUnknown(status)) return status;
    }
    semantic_.states.push_back(std::move(state));
    return absl::OkStatus();
  }

  absl::Status AddPosition(const XmlElement& element, SemanticState& state) {
    const absl::StatusOr<std::optional<int>> joint = JointAt(element, "name", names_);
    if (!joint.ok()) return joint.status();
    if (!joint->has_value()) {
      return Unknown(element, "name",
                     "must not be virtual: a question's x_world_base says where the robot stands");
    }
    const Joint& known = robot_.joints[**joint];
    if (known.kind == JointKind::kFixed) return Unknown(element, "name", "must not be fixed");
    absl::StatusOr<std::vector<double>> values =
        element.Numbers("value", static_cast<std::size_t>(VariableCount(known.kind)));
    if (!values.ok()) return values.status();
    for (const JointPosition& other : state.positions) {
      if (other.joint != known.name) continue;
      if (other.values != *values) {
        return element.Fault("must not appear twice in a state with different values");
      }
      left_out_.Add(absl::StrCat(element.place(), ": appears twice in the state, once is enough"));
      return absl::OkStatus();
    }
    state.positions.push_back({.joint = known.name, .values = *std::move(values)});
    return absl::OkStatus();
  }

  absl::Status AddEndEffector(const XmlElement& element) {
    EndEffector effector;
    const absl::StatusOr<std::string> name = element.Name("name");
    if (!name.ok()) return name.status();
    effector.name = *name;
    const absl::StatusOr<std::string> group = GroupAt(element, "group");
    if (!group.ok()) return group.status();
    effector.group = *group;
    const absl::StatusOr<int> link = LinkAt(element, "parent_link", names_);
    if (!link.ok()) return link.status();
    effector.parent_link = robot_.links[*link].name;
    if (element.Has("parent_group")) {
      const absl::StatusOr<std::string> parent = GroupAt(element, "parent_group");
      if (!parent.ok()) return parent.status();
      effector.parent_group = *parent;
    }
    semantic_.end_effectors.push_back(std::move(effector));
    return absl::OkStatus();
  }

  absl::Status AddPassiveJoint(const XmlElement& element) {
    const absl::StatusOr<std::optional<int>> joint = JointAt(element, "name", names_);
    if (!joint.ok()) return joint.status();
    semantic_.passive_joints.push_back(*element.Text("name"));
    return absl::OkStatus();
  }

  absl::StatusOr<NamedLinkPair> ReadPair(const XmlElement& element) const {
    const absl::StatusOr<int> link1 = LinkAt(element, "link1", names_);
    if (!link1.ok()) return link1.status();
    const absl::StatusOr<int> link2 = LinkAt(element, "link2", names_);
    if (!link2.ok()) return link2.status();
    if (*link1 == *link2) return element.FaultOf("link2", "must be another link than link1");
    return NamedLinkPair{.link1 = robot_.links[*link1].name,
                         .link2 = robot_.links[*link2].name,
                         .reason = element.Has("reason") ? *element.Text("reason") : ""};
  }

  absl::Status AddDisabledPair(const XmlElement& element) {
    absl::StatusOr<NamedLinkPair> pair = ReadPair(element);
    if (!pair.ok()) return pair.status();
    semantic_.disabled_pairs.push_back(*std::move(pair));
    return absl::OkStatus();
  }

  absl::Status AddEnabledPair(const XmlElement& element) {
    absl::StatusOr<NamedLinkPair> pair = ReadPair(element);
    if (!pair.ok()) return pair.status();
    semantic_.enabled_pairs.push_back(*std::move(pair));
    return absl::OkStatus();
  }

  absl::Status AddDisabledLink(const XmlElement& element) {
    const absl::StatusOr<int> link = LinkAt(element, "link", names_);
    if (!link.ok()) return link.status();
    semantic_.disabled_links.push_back(robot_.links[*link].name);
    return absl::OkStatus();
  }

  const RobotDescription& robot_;
  const RobotLimits& limits_;
  const std::stop_token stop_;
  RobotNames names_;
  std::set<std::string> groups_;
  std::set<std::pair<std::string, std::string>> states_;  // group and name
  SemanticDescription semantic_;
  SkippedElements left_out_;
};

}  // namespace

absl::StatusOr<SemanticDescription> ReadSrdf(std::string_view xml, const RobotDescription& robot,
                                             const RobotLimits& limits,
                                             const std::stop_token& stop) {
  const absl::StatusOr<XmlDocument> document =
      XmlDocument::Parse(XmlDocument::WithoutTrailingZeros(xml), "srdf", limits.max_xml_bytes);
  if (!document.ok()) return document.status();
  return SrdfReader(robot, limits, stop).Read(document->root());
}

}  // namespace cwm::collision
