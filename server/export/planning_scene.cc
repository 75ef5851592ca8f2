#include "server/export/planning_scene.h"

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/export/notes.h"

namespace cwm::server {
namespace {

using collision::PartSource;
using collision::RobotModel;

PlannerShape ShapeOf(const collision::WorldObject& object, const collision::PreparedPart& part) {
  PlannerShape shape = ToPlannerShape({part.X_OP, part.shape});
  const bool is_vessel = part.source == PartSource::kShape &&
                         object.model().shapes[static_cast<std::size_t>(part.index)].vessel;
  if (is_vessel) shape.note = "a vessel is written as its mesh";
  return shape;
}

std::int64_t TrianglesOf(const PlannerShape& shape) {
  const auto* mesh = std::get_if<PlannerMesh>(&shape.shape);
  return mesh == nullptr ? 0 : static_cast<std::int64_t>((*mesh)->triangles.size());
}

// The transform of a joint with several variables; `value` points to the first.
Pose TransformOf(collision::JointKind kind, const double* value) {
  if (kind == collision::JointKind::kPlanar) {
    return MakePose({value[0], value[1], 0},
                    Quaternion(Eigen::AngleAxisd(value[2], Vector3::UnitZ())));
  }
  return MakePose({value[0], value[1], value[2]},
                  Quaternion(value[6], value[3], value[4], value[5]).normalized());
}

PlannedRobotState StateOf(const collision::WorldRobot& robot) {
  PlannedRobotState state;
  // The default name of MoveIt's setup assistant; the name in the robot's SRDF is not kept.
  state.multi_dof_joints.push_back({"virtual_joint", robot.X_WB});
  const RobotModel& model = robot.model();
  for (std::size_t i = 0; i < model.variables.size(); ++i) {
    const collision::Variable& variable = model.variables[i];
    const collision::ModelLink& link = model.links[static_cast<std::size_t>(variable.link)];
    const bool is_multi_dof =
        link.kind == collision::JointKind::kPlanar || link.kind == collision::JointKind::kFloating;
    if (!is_multi_dof) state.joints.push_back({variable.name, robot.state[i]});
    if (is_multi_dof && variable.component == 0) {
      state.multi_dof_joints.push_back({link.joint, TransformOf(link.kind, &robot.state[i])});
    }
  }
  return state;
}

}  // namespace

absl::StatusOr<PlanningScene> MakePlanningScene(const collision::WorldSnapshot& snapshot,
                                                std::int64_t max_triangles,
                                                const CancellationCheck& check_cancelled) {
  PlanningScene scene;
  Notes notes;
  std::int64_t triangles = 0;
  for (const collision::WorldObjectPtr& object : snapshot.objects()) {
    if (absl::Status status = check_cancelled(); !status.ok()) return status;
    PlannedObject planned{.name = object->name, .X_WO = object->X_WO, .shapes = {}};
    if (const auto& held = object->attachment) {
      planned.attachment = {.robot = held->robot,
                            .link = held->link,
                            .X_LO = held->X_LO,
                            .touch_links = held->touch_links,
                            .supported_by = object->supported_by};
    }
    for (const collision::PreparedPart& part : object->geometry->parts) {
      planned.shapes.push_back(ShapeOf(*object, part));
      const PlannerShape& shape = planned.shapes.back();
      if (!shape.note.empty()) notes.Add(shape.note, object->name);
      triangles += TrianglesOf(shape);
      if (triangles <= max_triangles) continue;
      return MakeError(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("the meshes up to ", object->name, " have ", triangles,
                                    " triangles, must have at most ", max_triangles, " together"),
                       {.reason = "GEOMETRY_TOO_LARGE"});
    }
    if (object->kind == collision::ObjectKind::kUnseen) {
      notes.Add("becomes an object like any other, here it is space that no sensor has seen",
                object->name);
    }
    if (object->margin_m > 0) notes.Add("its margin is left out", object->name);
    if (!object->attachment && !object->supported_by.empty()) {
      notes.Add("what supports it is left out, a planner sees it touch that", object->name);
    }
    if (planned.shapes.empty()) {
      notes.Add("left out, it has no shapes", object->name);
    } else {
      scene.objects.push_back(std::move(planned));
    }
  }
  notes.AppendTo(scene.warnings);
  return scene;
}

absl::Status AddRobotAndRules(const collision::WorldSnapshot& snapshot,
                              const collision::WorldRobot* robot, PlanningScene& scene,
                              const CancellationCheck& check_cancelled) {
  if (robot != nullptr) {
    scene.robot_name = robot->model().name;
    scene.robot_state = StateOf(*robot);
  }
  Notes notes;
  for (PlannedObject& object : scene.objects) {
    if (!object.attachment) continue;
    if (robot && object.attachment->robot == robot->name) {
      const std::string& support = object.attachment->supported_by;
      if (!support.empty()) {
        notes.Add("what supports it is left out, a planner sees it touch that", object.name);
      }
      continue;
    }
    scene.warnings.push_back(
        absl::StrCat(object.name, ": stands free, it is attached to ", object.attachment->robot));
    object.attachment.reset();
  }
  notes.AppendTo(scene.warnings);
  auto allowed = MakeAllowedCollisionMatrix(snapshot, robot, scene.warnings, check_cancelled);
  if (!allowed.ok()) return allowed.status();
  scene.allowed = *std::move(allowed);
  for (const collision::WorldRobotPtr& other : snapshot.robots()) {
    if (other.get() == robot) continue;
    scene.warnings.push_back(absl::StrCat(other->name, ": left out, a scene has one robot"));
  }
  return absl::OkStatus();
}

void RemoveAttached(PlanningScene& scene) {
  const auto is_attached = [](const PlannedObject& object) {
    return object.attachment.has_value();
  };
  for (const PlannedObject& object : scene.objects) {
    if (!is_attached(object)) continue;
    scene.warnings.push_back(
        absl::StrCat(object.name, ": left out, it is attached to ", object.attachment->robot));
  }
  std::erase_if(scene.objects, is_attached);
}

}  // namespace cwm::server
