#include "collision/robot/srdf_groups.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::collision {
namespace {

class GroupReader {
 public:
  GroupReader(const std::vector<XmlElement>& elements, const RobotDescription& robot,
              const KinematicTree& tree, const RobotNames& names, SkippedElements& left_out,
              std::stop_token stop)
      : elements_(elements),
        robot_(robot),
        tree_(tree),
        names_(names),
        left_out_(left_out),
        stop_(std::move(stop)) {}

  absl::StatusOr<std::vector<SemanticGroup>> Read() {
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      const absl::StatusOr<std::string> name = elements_[i].Name("name");
      if (!name.ok()) return name.status();
      if (!index_.emplace(*name, static_cast<int>(i)).second) {
        return elements_[i].Fault("must not appear twice");
      }
    }
    members_.resize(elements_.size());
    stages_.resize(elements_.size(), Stage::kUntouched);
    std::vector<SemanticGroup> groups;
    for (const auto& element : elements_) {
      const std::string name = *element.Name("name");
      if (absl::Status status = Resolve(index_.at(name)); !status.ok()) return status;
      groups.push_back({.name = name, .joints = InOrder(members_[index_.at(name)])});
    }
    return groups;
  }

 private:
  enum class Stage { kUntouched, kOpen, kDone };
  using Members = std::vector<bool>;  // by joint

  // Recurses into subgroups, at most as deep as there are groups.
  absl::Status Resolve(int group) {
    if (stages_[group] == Stage::kDone) return absl::OkStatus();
    stages_[group] = Stage::kOpen;
    Members members(robot_.joints.size(), false);
    for (const XmlElement& child : elements_[group].Children()) {
      if (stop_.stop_requested()) return absl::CancelledError();
      absl::Status status;
      if (child.tag() == "joint") status = AddJoint(child, members);
      if (child.tag() == "link") status = AddLink(child, members);
      if (child.tag() == "chain") status = AddChain(child, members);
      if (child.tag() == "group") status = AddGroup(child, members);
      if (!status.ok() && !left_out_.AddIfUnknown(status)) return status;
    }
    members_[group] = std::move(members);
    stages_[group] = Stage::kDone;
    return absl::OkStatus();
  }

  absl::Status AddJoint(const XmlElement& element, Members& members) const {
    const absl::StatusOr<std::optional<int>> joint = JointAt(element, "name", names_);
    if (!joint.ok()) return joint.status();
    if (joint->has_value()) members[**joint] = true;
    return absl::OkStatus();
  }

  absl::Status AddLink(const XmlElement& element, Members& members) const {
    const absl::StatusOr<int> link = LinkAt(element, "name", names_);
    if (!link.ok()) return link.status();
    if (tree_.joint_of[*link].has_value()) members[*tree_.joint_of[*link]] = true;
    return absl::OkStatus();
  }

  absl::Status AddChain(const XmlElement& element, Members& members) const {
    const absl::StatusOr<int> base = LinkAt(element, "base_link", names_);
    if (!base.ok()) return base.status();
    const absl::StatusOr<int> tip = LinkAt(element, "tip_link", names_);
    if (!tip.ok()) return tip.status();
    std::vector<bool> above_base(robot_.links.size(), false);
    for (std::optional<int> at = *base; at.has_value(); at = tree_.parent_of[*at]) {
      above_base[*at] = true;
    }
    int meeting = *tip;  // the root is above both
    while (!above_base[meeting]) meeting = *tree_.parent_of[meeting];
    for (const int end : {*base, *tip}) {
      for (int at = end; at != meeting; at = *tree_.parent_of[at]) {
        members[*tree_.joint_of[at]] = true;
      }
    }
    return absl::OkStatus();
  }

  absl::Status AddGroup(const XmlElement& element, Members& members) {
    const absl::StatusOr<std::string> name = element.Name("name");
    if (!name.ok()) return name.status();
    const auto group = index_.find(*name);
    if (group == index_.end()) return Unknown(element, "name", "must be a group of the SRDF");
    if (stages_[group->second] == Stage::kOpen) {
      return element.FaultOf("name", "must not be a group that holds this one");
    }
    if (absl::Status status = Resolve(group->second); !status.ok()) return status;
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (members_[group->second][i]) members[i] = true;
    }
    return absl::OkStatus();
  }

  std::vector<std::string> InOrder(const Members& members) const {
    std::vector<std::string> joints;
    for (const int link : tree_.order) {
      const std::optional<int> joint = tree_.joint_of[link];
      if (joint.has_value() && members[*joint]) joints.push_back(robot_.joints[*joint].name);
    }
    return joints;
  }

  const std::vector<XmlElement>& elements_;
  const RobotDescription& robot_;
  const KinematicTree& tree_;
  const RobotNames& names_;
  SkippedElements& left_out_;
  const std::stop_token stop_;
  std::map<std::string, int> index_;
  std::vector<Members> members_;
  std::vector<Stage> stages_;
};

}  // namespace

void SkippedElements::Add(std::string what) {
  if (lines_.size() == kMaxLeftOut) {
    ++more_;
  } else {
    lines_.push_back(std::move(what) + "; left out");
  }
}

bool SkippedElements::AddIfUnknown(const absl::Status& status) {
  if (!absl::IsNotFound(status)) return false;
  Add(std::string(status.message()));
  return true;
}

std::vector<std::string> SkippedElements::Lines() const {
  std::vector<std::string> lines = lines_;
  if (more_ > 0) {
    lines.push_back(absl::StrCat("srdf: ", more_, " more elements that are left out"));
  }
  return lines;
}

absl::Status Unknown(const XmlElement& element, const char* attribute, std::string_view rule) {
  return absl::NotFoundError(element.FaultOf(attribute, rule).message());
}

absl::StatusOr<int> LinkAt(const XmlElement& element, const char* attribute,
                           const RobotNames& names) {
  const absl::StatusOr<std::string> name = element.Text(attribute);
  if (!name.ok()) return name.status();
  const auto link = names.links.find(*name);
  if (link == names.links.end()) return Unknown(element, attribute, "must be a link of the robot");
  return link->second;
}

absl::StatusOr<std::optional<int>> JointAt(const XmlElement& element, const char* attribute,
                                           const RobotNames& names) {
  const absl::StatusOr<std::string> name = element.Text(attribute);
  if (!name.ok()) return name.status();
  const auto joint = names.joints.find(*name);
  if (joint != names.joints.end()) return std::optional<int>(joint->second);
  if (names.virtual_joints.count(*name) > 0) return std::optional<int>();
  return Unknown(element, attribute, "must be a joint of the robot");
}

absl::StatusOr<std::vector<SemanticGroup>> ReadGroups(const std::vector<XmlElement>& elements,
                                                      const RobotDescription& robot,
                                                      const KinematicTree& tree,
                                                      const RobotNames& names,
                                                      SkippedElements& left_out,
                                                      const std::stop_token& stop) {
  return GroupReader(elements, robot, tree, names, left_out, stop).Read();
}

}  // namespace cwm::collision
