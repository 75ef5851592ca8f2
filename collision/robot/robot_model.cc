#include "collision/robot/robot_model.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/robot/kinematic_tree.h"
#include "collision/robot/mimic.h"
#include "collision/robot/named_states.h"
#include "collision/robot/self_pairs.h"
#include "collision/robot/state_range.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// The suffixes of a joint's variable names.
std::vector<std::string> Suffixes(JointKind kind) {
  if (kind == JointKind::kPlanar) return {"/x", "/y", "/theta"};
  if (kind == JointKind::kFloating) {
    return {"/trans_x", "/trans_y", "/trans_z", "/rot_x", "/rot_y", "/rot_z", "/rot_w"};
  }
  return std::vector<std::string>(VariableCount(kind), "");
}

class ModelMaker {
 public:
  ModelMaker(RobotDescription description, const SemanticDescription* semantic)
      : robot_(std::move(description)), semantic_(semantic) {}

  absl::StatusOr<std::shared_ptr<const RobotModel>> Make() {
    absl::StatusOr<KinematicTree> tree = MakeKinematicTree(robot_);
    if (!tree.ok()) return tree.status();
    absl::StatusOr<std::vector<std::optional<ResolvedMimic>>> resolved_mimics =
        ResolveMimics(robot_);
    if (!resolved_mimics.ok()) return resolved_mimics.status();
    model_->name = robot_.name;
    AddLinks(*tree);
    AddVariables();
    SetMimics(*tree, *resolved_mimics);
    if (absl::Status status = CheckReach(*model_); !status.ok()) return status;
    model_->all.variables.resize(model_->variables.size());
    for (std::size_t i = 0; i < model_->all.variables.size(); ++i) {
      model_->all.variables[i] = static_cast<int>(i);
    }
    FinishGroup(model_->all);
    model_->left_out = robot_.left_out;
    if (semantic_ != nullptr) {
      model_->left_out.insert(model_->left_out.end(), semantic_->left_out.begin(),
                              semantic_->left_out.end());
    }
    if (absl::Status status = AddGroups(); !status.ok()) return status;
    model_->self_pairs = SelfPairs(*model_, semantic_);
    return std::shared_ptr<const RobotModel>(std::move(model_));
  }

 private:
  void AddLinks(const KinematicTree& tree) {
    std::vector<int> index_of(robot_.links.size());  // by index in the description
    for (const int urdf_index : tree.order) {
      const int index = static_cast<int>(model_->links.size());
      index_of[urdf_index] = index;
      ModelLink link;
      link.name = robot_.links[urdf_index].name;
      link.urdf_index = urdf_index;
      link.collisions = std::move(robot_.links[urdf_index].collisions);
      if (tree.parent_of[urdf_index].has_value()) {
        link.parent = index_of[*tree.parent_of[urdf_index]];
        SetJoint(robot_.joints[*tree.joint_of[urdf_index]], link);
        model_->joint_index.emplace(link.joint, index);
      }
      const bool rides = index > 0 && link.kind == JointKind::kFixed;
      link.body = rides ? model_->links[link.parent].body : index;
      model_->link_index.emplace(link.name, index);
      model_->links.push_back(std::move(link));
    }
  }

  static void SetJoint(const Joint& joint, ModelLink& link) {
    link.joint = joint.name;
    link.kind = joint.kind;
    link.X_PJ = joint.X_PJ;
    link.axis_J = joint.axis_J;
    link.is_mimic = joint.mimic.has_value();
  }

  void AddVariables() {
    std::map<std::string, const Joint*> joints;
    for (const Joint& joint : robot_.joints) joints.emplace(joint.name, &joint);
    for (std::size_t i = 0; i < model_->links.size(); ++i) {
      ModelLink& link = model_->links[i];
      if (link.is_mimic) continue;
      link.variable = static_cast<int>(model_->variables.size());
      for (const std::string& suffix : Suffixes(link.kind)) {
        const JointLimits& limits = joints.at(link.joint)->limits;
        model_->variables.push_back(
            {.name = link.joint + suffix,
             .link = static_cast<int>(i),
             .component = static_cast<int>(model_->variables.size()) - link.variable,
             .lower = limits.lower.value_or(-kUnlimited),
             .upper = limits.upper.value_or(kUnlimited)});
      }
    }
  }

  // Runs after all variables are known, because a mimic joint may come before its source. MoveIt
  // ignores the limits of mimic joints; here a state that puts a finger outside its limits is not
  // valid.
  void SetMimics(const KinematicTree& tree,
                 const std::vector<std::optional<ResolvedMimic>>& resolved_mimics) {
    for (ModelLink& link : model_->links) {
      if (!link.is_mimic) continue;
      const ResolvedMimic& resolved = *resolved_mimics[*tree.joint_of[link.urdf_index]];
      const int source = *model_->FindJoint(robot_.joints[resolved.source].name);
      link.variable = model_->links[source].variable;
      link.multiplier = resolved.multiplier;
      link.offset = resolved.offset;
      Narrow(robot_.joints[*tree.joint_of[link.urdf_index]], resolved,
             model_->variables[link.variable]);
    }
  }

  void Narrow(const Joint& follower, const ResolvedMimic& resolved, Variable& variable) {
    const VariableRange range = {.lower = variable.lower, .upper = variable.upper};
    const std::optional<VariableRange> narrowed = NarrowRange(range, resolved, follower.limits);
    if (!narrowed.has_value()) {
      model_->contradicting.push_back(follower.name);
    } else if (narrowed->lower != range.lower || narrowed->upper != range.upper) {
      model_->narrowing.push_back(follower.name);
      variable.lower = narrowed->lower;
      variable.upper = narrowed->upper;
    }
  }

  absl::Status AddGroups() {
    if (semantic_ == nullptr) return absl::OkStatus();
    for (const SemanticGroup& semantic : semantic_->groups) {
      JointGroup group{
          .name = semantic.name, .variables = {}, .joints = {}, .moved_links = {}, .states = {}};
      for (const std::string& joint : semantic.joints) {
        const std::optional<int> link = model_->FindJoint(joint);
        if (!link.has_value()) return Unknown("joint", joint, semantic.name);
        AppendVariables(model_->links[*link], group.variables);
      }
      std::sort(group.variables.begin(), group.variables.end());
      FinishGroup(group);
      if (!model_->group_index.emplace(group.name, model_->groups.size()).second) {
        return FaultAt(absl::StrCat("srdf: group ", Quoted(group.name)), "must not appear twice");
      }
      model_->groups.push_back(std::move(group));
    }
    return AddStates();
  }

  static absl::Status Unknown(const char* what, const std::string& name, const std::string& group) {
    return FaultAt(absl::StrCat("srdf: group ", Quoted(group), ": ", what, " is ", Quoted(name)),
                   absl::StrCat("must be a ", what, " of the robot"));
  }

  static void AppendVariables(const ModelLink& link, std::vector<int>& variables) {
    if (link.is_mimic) return;
    for (int i = 0; i < VariableCount(link.kind); ++i) variables.push_back(link.variable + i);
  }

  // Sets the members of a group that follow from its variables.
  void FinishGroup(JointGroup& group) const {
    std::vector<bool> is_varied(model_->variables.size(), false);
    for (const int i : group.variables) {
      is_varied[i] = true;
      const Variable& variable = model_->variables[i];
      if (variable.component == 0) group.joints.push_back(model_->links[variable.link].joint);
    }
    std::vector<bool> is_moved(model_->links.size(), false);
    for (std::size_t i = 1; i < model_->links.size(); ++i) {
      const ModelLink& link = model_->links[i];
      is_moved[i] =
          is_moved[link.parent] || (link.kind != JointKind::kFixed && is_varied[link.variable]);
      if (is_moved[i]) group.moved_links.push_back(static_cast<int>(i));
    }
    group.tool_link = ToolLinkOf(group, is_moved);
  }

  std::optional<int> ToolLinkOf(const JointGroup& group, const std::vector<bool>& is_moved) const {
    for (const EndEffector& effector :
         semantic_ != nullptr ? semantic_->end_effectors : std::vector<EndEffector>()) {
      const std::optional<int> link = model_->FindLink(effector.parent_link);
      if (!link || !is_moved[*link] || effector.group == group.name) continue;
      if (effector.parent_group == group.name || effector.parent_group.empty()) return link;
    }
    std::vector<bool> is_end = is_moved;
    for (const int link : group.moved_links) is_end[model_->links[link].parent] = false;
    if (std::ranges::count(is_end, true) != 1) return std::nullopt;
    return static_cast<int>(std::ranges::find(is_end, true) - is_end.begin());
  }

  absl::Status AddStates() {
    SkippedElements left_out;
    for (const SemanticState& semantic : semantic_->states) {
      const auto found = model_->group_index.find(semantic.group);
      if (found == model_->group_index.end()) {
        return FaultAt(absl::StrCat("srdf: group_state ", Quoted(semantic.name), " group is ",
                                    Quoted(semantic.group)),
                       "must be a group of the SRDF");
      }
      JointGroup& group = model_->groups[found->second];
      for (const JointPosition& position : semantic.positions) {
        if (!model_->FindJoint(position.joint).has_value()) {
          return Unknown("joint", position.joint, semantic.group);
        }
      }
      group.states.push_back(MakeNamedState(semantic, *model_, group, left_out));
    }
    const std::vector<std::string> lines = left_out.Lines();
    model_->left_out.insert(model_->left_out.end(), lines.begin(), lines.end());
    return absl::OkStatus();
  }

  RobotDescription robot_;
  const SemanticDescription* semantic_;
  std::shared_ptr<RobotModel> model_ = std::make_shared<RobotModel>();
};

std::optional<int> Find(const std::map<std::string, int, std::less<>>& index,
                        std::string_view name) {
  const auto found = index.find(name);
  return found == index.end() ? std::nullopt : std::optional<int>(found->second);
}

}  // namespace

std::optional<int> RobotModel::FindLink(std::string_view name) const {
  return Find(link_index, name);
}

std::optional<int> RobotModel::FindJoint(std::string_view name) const {
  return Find(joint_index, name);
}

const JointGroup* RobotModel::FindGroup(std::string_view name) const {
  const std::optional<int> group = Find(group_index, name);
  return group.has_value() ? &groups[*group] : nullptr;
}

const RobotTool* RobotModel::FindTool(std::string_view name) const {
  const auto found = std::ranges::find(tools, name, &RobotTool::name);
  return found == tools.end() ? nullptr : &*found;
}

absl::StatusOr<std::shared_ptr<const RobotModel>> MakeRobotModel(
    RobotDescription description, const SemanticDescription* semantic) {
  return ModelMaker(std::move(description), semantic).Make();
}

}  // namespace cwm::collision
