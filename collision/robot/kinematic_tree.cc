#include "collision/robot/kinematic_tree.h"

#include <functional>
#include <map>
#include <queue>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

class TreeMaker {
 public:
  explicit TreeMaker(const RobotDescription& robot) : robot_(robot) {}

  absl::StatusOr<KinematicTree> Make() {
    if (robot_.links.empty()) return FaultAt("urdf", "must have at least one link");
    if (absl::Status status = IndexLinks(); !status.ok()) return status;
    if (absl::Status status = LinkParents(); !status.ok()) return status;
    if (absl::Status status = FindRoot(); !status.ok()) return status;
    if (absl::Status status = Order(); !status.ok()) return status;
    return std::move(tree_);
  }

 private:
  absl::Status IndexLinks() {
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      const std::string& name = robot_.links[i].name;
      if (!link_index_.emplace(name, static_cast<int>(i)).second) {
        return FaultAt(absl::StrCat("urdf: link ", Quoted(name)), "must not appear twice");
      }
    }
    return absl::OkStatus();
  }

  absl::Status Fault(const Joint& joint, const char* element, const std::string& link,
                     const std::string& rule) const {
    return FaultAt(
        absl::StrCat("urdf: joint ", Quoted(joint.name), ": ", element, " link is ", Quoted(link)),
        rule);
  }

  absl::Status LinkParents() {
    tree_.joint_of.resize(robot_.links.size());
    tree_.parent_of.resize(robot_.links.size());
    children_.resize(robot_.links.size());
    std::map<std::string, int> joints;
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      const Joint& joint = robot_.joints[i];
      if (!joints.emplace(joint.name, static_cast<int>(i)).second) {
        return FaultAt(absl::StrCat("urdf: joint ", Quoted(joint.name)), "must not appear twice");
      }
      if (absl::Status status = LinkParents(static_cast<int>(i)); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status LinkParents(int index) {
    const Joint& joint = robot_.joints[index];
    const auto parent = link_index_.find(joint.parent);
    const auto child = link_index_.find(joint.child);
    if (parent == link_index_.end()) {
      return Fault(joint, "parent", joint.parent, "must be a link of the robot");
    }
    if (child == link_index_.end()) {
      return Fault(joint, "child", joint.child, "must be a link of the robot");
    }
    std::optional<int>& hangs_on = tree_.joint_of[child->second];
    if (hangs_on.has_value()) {
      return Fault(joint, "child", joint.child,
                   absl::StrCat("must have one parent, but is the child of joint ",
                                Quoted(robot_.joints[*hangs_on].name), " too"));
    }
    hangs_on = index;
    tree_.parent_of[child->second] = parent->second;
    children_[parent->second].push_back(child->second);
    return absl::OkStatus();
  }

  absl::Status FindRoot() {
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      if (tree_.joint_of[i].has_value()) continue;
      if (root_.has_value()) {
        return FaultAt(absl::StrCat("urdf: links ", Quoted(robot_.links[*root_].name), " and ",
                                    Quoted(robot_.links[i].name)),
                       "must not both be roots, each link but one must be the child of a joint");
      }
      root_ = static_cast<int>(i);
    }
    return root_.has_value() ? absl::OkStatus() : CycleAbove(0);
  }

  absl::Status Order() {
    std::priority_queue<int, std::vector<int>, std::greater<>> ready;
    ready.push(*root_);
    std::vector<bool> placed(robot_.links.size(), false);
    while (!ready.empty()) {
      const int link = ready.top();
      ready.pop();
      tree_.order.push_back(link);
      placed[link] = true;
      for (const int child : children_[link]) ready.push(child);
    }
    for (std::size_t i = 0; i < placed.size(); ++i) {
      if (!placed[i]) return CycleAbove(static_cast<int>(i));
    }
    return absl::OkStatus();
  }

  // The error for a link that is not connected to a root: after as many steps up as there are
  // links, the walk is on a cycle.
  absl::Status CycleAbove(int link) const {
    for (std::size_t i = 0; i < robot_.links.size(); ++i) link = *tree_.parent_of[link];
    return FaultAt(absl::StrCat("urdf: joint ", Quoted(robot_.joints[*tree_.joint_of[link]].name)),
                   "is part of a cycle, links and joints must form a tree");
  }

  const RobotDescription& robot_;
  KinematicTree tree_;
  std::map<std::string, int> link_index_;
  std::vector<std::vector<int>> children_;
  std::optional<int> root_;
};

}  // namespace

absl::StatusOr<KinematicTree> MakeKinematicTree(const RobotDescription& robot) {
  return TreeMaker(robot).Make();
}

}  // namespace cwm::collision
