#include "server/wire/robots.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/robot_settings.h"
#include "server/wire/shapes.h"

namespace cwm::server {
namespace {

using collision::ModelLink;
using collision::RobotModel;

// chosen: the length of the longest names of variables: a joint's name, which XML does not limit,
// with the component's.
constexpr std::int64_t kMaxNameBytes = 1'024;

std::int64_t TrianglesOf(const ModelLink& link) {
  std::size_t triangles = 0;
  for (const collision::CollisionGeometry& collision : link.collisions) {
    const Mesh* mesh = std::get_if<Mesh>(&collision.shape);
    if (mesh != nullptr) triangles += mesh->mesh->triangles.size();
  }
  return static_cast<std::int64_t>(triangles);
}

v1::RobotLink LinkMessage(const collision::RobotGeometry& robot, std::size_t index) {
  const ModelLink& link = robot.model->links[index];
  v1::RobotLink proto;
  proto.set_name(link.name);
  proto.set_collision_count(static_cast<int>(link.collisions.size()));
  proto.set_triangle_count(TrianglesOf(link));
  if (robot.spheres_as_given.has_value()) {
    proto.set_sphere_count(static_cast<int>(robot.spheres_as_given->links[index].size()));
  }
  proto.set_padding_m(link.padding_m);
  proto.set_scale(link.scale);
  if (link.joint.empty()) return proto;  // the root link has no parent
  proto.set_parent(robot.model->links[link.parent].name);
  proto.set_joint(link.joint);
  proto.set_joint_kind(JointKindToProto(link.kind));
  if (link.is_mimic) {
    proto.set_follows(robot.model->links[robot.model->variables[link.variable].link].joint);
  }
  return proto;
}

// Sets the pairs of links with shapes that are not checked: the complement of the checked pairs.
void SetUncheckedLinks(const RobotModel& model, v1::Robot& proto) {
  const std::size_t count = model.links.size();
  std::vector<bool> is_checked(count * count);
  for (const collision::LinkPair& pair : model.self_pairs) {
    const auto [first, second] = std::minmax(pair.first, pair.second);
    is_checked[static_cast<std::size_t>(first) * count + static_cast<std::size_t>(second)] = true;
  }
  const auto has_shapes = [&](std::size_t link) { return !model.links[link].collisions.empty(); };
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count && has_shapes(a); ++b) {
      if (!has_shapes(b) || is_checked[a * count + b]) continue;
      proto.mutable_links(static_cast<int>(a))->add_unchecked_links(static_cast<std::int32_t>(b));
    }
  }
}

v1::RobotVariable VariableMessage(const RobotModel& model, const collision::Variable& variable) {
  const ModelLink& link = model.links[variable.link];
  v1::RobotVariable proto;
  proto.set_name(variable.name);
  proto.set_joint(link.joint);
  proto.set_joint_kind(JointKindToProto(link.kind));
  if (std::isfinite(variable.lower)) proto.set_lower(variable.lower);
  if (std::isfinite(variable.upper)) proto.set_upper(variable.upper);
  return proto;
}

v1::RobotGroup GroupMessage(const RobotModel& model, const collision::JointGroup& group) {
  v1::RobotGroup proto;
  proto.set_name(group.name);
  for (const std::string& joint : group.joints) proto.add_joints(joint);
  for (const collision::NamedState& state : group.states) {
    v1::NamedState* named = proto.add_states();
    named->set_name(state.name);
    for (std::size_t i = 0; i < state.variables.size(); ++i) {
      v1::VariableValue* value = named->add_values();
      value->set_variable(model.variables[state.variables[i]].name);
      value->set_value(state.values[i]);
    }
  }
  return proto;
}

}  // namespace

v1::JointKind JointKindToProto(collision::JointKind kind) {
  switch (kind) {
    case collision::JointKind::kFixed:
      return v1::JOINT_KIND_FIXED;
    case collision::JointKind::kRevolute:
      return v1::JOINT_KIND_REVOLUTE;
    case collision::JointKind::kContinuous:
      return v1::JOINT_KIND_CONTINUOUS;
    case collision::JointKind::kPrismatic:
      return v1::JOINT_KIND_PRISMATIC;
    case collision::JointKind::kPlanar:
      return v1::JOINT_KIND_PLANAR;
    case collision::JointKind::kFloating:
      return v1::JOINT_KIND_FLOATING;
  }
  return v1::JOINT_KIND_UNSPECIFIED;
}

v1::Robot RobotToProto(const collision::WorldRobot& robot) {
  const RobotModel& model = robot.model();
  v1::Robot proto;
  proto.set_name(robot.name);
  proto.set_uid(robot.Uid());
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    *proto.add_links() = LinkMessage(*robot.robot, i);
  }
  SetUncheckedLinks(model, proto);
  for (const collision::Variable& variable : model.variables) {
    *proto.add_variables() = VariableMessage(model, variable);
  }
  for (const collision::JointGroup& group : model.groups) {
    *proto.add_groups() = GroupMessage(model, group);
  }
  for (const collision::RobotTool& tool : model.tools) {
    *proto.add_tools() = RobotToolToProto(tool, model);
  }
  proto.set_self_pair_count(static_cast<std::int64_t>(model.self_pairs.size()));
  *proto.mutable_x_world_base() = PoseToProto(robot.X_WB);
  proto.mutable_state()->Add(robot.state.begin(), robot.state.end());
  proto.set_create_revision(robot.create_revision.value);
  proto.set_state_revision(robot.state_revision.value);
  return proto;
}

void SetLinks(const collision::WorldRobot& robot, LinkShapes shapes, GeometryStore& store,
              v1::GetRobotLinksResponse* response) {
  const RobotModel& model = robot.model();
  response->set_robot_uid(robot.Uid());
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    v1::PlacedLink* link = response->add_links();
    link->set_link(model.links[i].name);
    *link->mutable_x_world_link() = PoseToProto(robot.X_WL[i]);
    if (shapes == LinkShapes::kNone) continue;
    for (const collision::CollisionGeometry& geometry : model.links[i].collisions) {
      *link->add_shapes() =
          ShapePartToProto(ShapePart{.X_OS = geometry.X_LG, .shape = geometry.shape}, store);
    }
  }
}

v1::RobotStateEvent ToStateEvent(const collision::WorldRobot& robot) {
  v1::RobotStateEvent proto;
  proto.set_name(robot.name);
  *proto.mutable_x_world_base() = PoseToProto(robot.X_WB);
  proto.mutable_state()->Add(robot.state.begin(), robot.state.end());
  proto.set_state_revision(robot.state_revision.value);
  return proto;
}

absl::StatusOr<collision::JointValues> JointValuesFromProto(const v1::RobotJointState& joints,
                                                            const FieldPath& path) {
  collision::JointValues result;
  if (joints.group().empty() != joints.named_state().empty()) {
    return path.Field(joints.group().empty() ? "group" : "named_state")
        .Error("is empty, must be given: a named state is one of a group");
  }
  if (!joints.group().empty()) result.named = {joints.group(), joints.named_state()};
  for (int i = 0; i < joints.values_size(); ++i) {
    const v1::VariableValue& value = joints.values(i);
    const FieldPath item = path.Item("values", i);
    auto status = CheckTextLength(value.variable(), kMaxNameBytes, item.Field("variable"));
    if (!status.ok()) return status;
    if (status = CheckCoordinate(value.value(), item.Field("value")); !status.ok()) return status;
    result.values.push_back({value.variable(), value.value()});
  }
  return result;
}

absl::StatusOr<collision::SetRobotState> SetRobotStateFromProto(const v1::SetRobotState& set,
                                                                const FieldPath& path) {
  collision::SetRobotState result;
  if (auto status = CheckName(set.name(), path.Field("name")); !status.ok()) return status;
  result.name = set.name();
  if (set.has_x_world_base()) {
    auto X_WB = PoseFromProto(set.x_world_base(), path.Field("x_world_base"));
    if (!X_WB.ok()) return X_WB.status();
    result.X_WB = *X_WB;
  }
  auto joints = JointValuesFromProto(set.joints(), path.Field("joints"));
  if (!joints.ok()) return joints.status();
  result.joints = *std::move(joints);
  return result;
}

}  // namespace cwm::server
