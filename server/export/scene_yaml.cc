// moveit_msgs/PlanningScene in YAML; declared in moveit_scene.h.
#include <functional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/export/moveit_scene.h"
#include "server/export/scene_numbers.h"

namespace cwm::server {
namespace {

template <class T>
const T* As(const PlannerShape& shape) {
  return std::get_if<T>(&shape.shape);
}

std::string Names(const std::vector<std::string>& names) {
  return absl::StrCat("[",
                      absl::StrJoin(names, ", ",
                                    [](std::string* out, const std::string& name) {
                                      absl::StrAppend(out, Quoted(name));
                                    }),
                      "]");
}

std::string PoseText(const Pose& pose) {
  return absl::StrCat("{position: [", Text(pose.translation(), ", "), "], orientation: [",
                      RotationText(pose, ", "), "]}");
}

std::string TransformText(const Pose& pose) {
  return absl::StrCat("{translation: [", Text(pose.translation(), ", "), "], rotation: [",
                      RotationText(pose, ", "), "]}");
}

std::string PrimitiveText(const PlannerPrimitive& primitive) {
  static constexpr const char* kNames[] = {"box", "sphere", "cylinder", "cone"};
  std::vector<std::string> numbers;
  for (int i = 0; i < primitive.dimension_count; ++i) {
    numbers.push_back(NumberText(primitive.dimensions_m[static_cast<std::size_t>(i)]));
  }
  return absl::StrCat("{type: ", kNames[static_cast<std::size_t>(primitive.kind)],
                      ", dimensions: [", absl::StrJoin(numbers, ", "), "]}");
}

std::string MeshText(const TriangleMesh& mesh) {
  std::string text = "{vertices: [";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    absl::StrAppend(&text, i == 0 ? "[" : ", [", Text(mesh.vertices[i], ", "), "]");
  }
  absl::StrAppend(&text, "], triangles: [");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    absl::StrAppend(&text, i == 0 ? "[" : ", [", a, ", ", b, ", ", c, "]");
  }
  return text + "]}";
}

// The shapes of one kind and their poses, as two lists.
template <class T>
void AppendShapes(const PlannedObject& object, const char* shapes_key, const char* poses_key,
                  const Pose& X_WS_of_object, const std::function<std::string(const T&)>& say,
                  std::string& yaml) {
  std::string poses;
  bool is_first = true;
  for (const PlannerShape& shape : object.shapes) {
    const T* typed = As<T>(shape);
    if (typed == nullptr) continue;
    if (is_first) absl::StrAppend(&yaml, "      ", shapes_key, ":\n");
    is_first = false;
    absl::StrAppend(&yaml, "        - ", say(*typed), "\n");
    absl::StrAppend(&poses, "        - ", PoseText(X_WS_of_object * shape.X_OS), "\n");
  }
  if (!is_first) absl::StrAppend(&yaml, "      ", poses_key, ":\n", poses);
}

// An object of one shape has no pose of its own but that of the shape: so it is read by every
// version, those before objects had poses included.
void AppendObject(const PlannedObject& object, std::string& yaml) {
  absl::StrAppend(&yaml, "    - id: ", Quoted(object.name), "\n");
  const bool is_its_shape = object.shapes.size() == 1;
  const Pose X_WF = is_its_shape ? object.X_WO : Pose::Identity();
  if (!is_its_shape) absl::StrAppend(&yaml, "      pose: ", PoseText(object.X_WO), "\n");
  AppendShapes<PlannerPrimitive>(object, "primitives", "primitive_poses", X_WF, PrimitiveText,
                                 yaml);
  AppendShapes<PlannerMesh>(
      object, "meshes", "mesh_poses", X_WF, [](const PlannerMesh& mesh) { return MeshText(*mesh); },
      yaml);
  AppendShapes<PlannerPlane>(
      object, "planes", "plane_poses", X_WF,
      [](const PlannerPlane&) { return std::string("{coef: [0, 0, 1, 0]}"); }, yaml);
}

void AppendState(const PlannedRobotState& state, std::string& yaml) {
  std::vector<std::string> names, positions;
  for (const PlannedJoint& joint : state.joints) {
    names.push_back(joint.name);
    positions.push_back(NumberText(joint.position));
  }
  absl::StrAppend(&yaml, "robot_state:\n  joint_state:\n    name: ", Names(names),
                  "\n    position: [", absl::StrJoin(positions, ", "), "]\n");
  names.clear();
  std::vector<std::string> transforms;
  for (const PlannedMultiDofJoint& joint : state.multi_dof_joints) {
    names.push_back(joint.name);
    transforms.push_back(TransformText(joint.transform));
  }
  absl::StrAppend(&yaml, "  multi_dof_joint_state:\n    joint_names: ", Names(names),
                  "\n    transforms: [", absl::StrJoin(transforms, ", "), "]\n");
}

void AppendMatrix(const AllowedMatrix& matrix, std::string& yaml) {
  absl::StrAppend(&yaml, "allowed_collision_matrix:\n  entry_names: ", Names(matrix.names),
                  "\n  entry_values:\n");
  for (const std::vector<bool>& row : matrix.allowed) {
    yaml += "    - [";
    for (std::size_t i = 0; i < row.size(); ++i) {
      absl::StrAppend(&yaml, i == 0 ? "" : ", ", row[i] ? "true" : "false");
    }
    yaml += "]\n";
  }
  if (matrix.by_default.empty()) return;
  const std::vector<std::string> values(matrix.by_default.size(), "true");
  absl::StrAppend(&yaml, "  default_entry_names: ", Names(matrix.by_default),
                  "\n  default_entry_values: [", absl::StrJoin(values, ", "), "]\n");
}

}  // namespace

std::string FormatSceneYaml(const PlanningScene& scene) {
  std::string yaml = absl::StrCat("name: ", Quoted(scene.name), "\n");
  if (!scene.robot_name.empty()) {
    absl::StrAppend(&yaml, "robot_model_name: ", Quoted(scene.robot_name), "\n");
    AppendState(scene.robot_state, yaml);
  }
  absl::StrAppend(&yaml, "fixed_frame_transforms:\n  - child_frame_id: world\n    transform: ",
                  TransformText(Pose::Identity()), "\n");
  if (!scene.allowed.names.empty()) AppendMatrix(scene.allowed, yaml);
  absl::StrAppend(&yaml, "world:\n  collision_objects:", scene.objects.empty() ? " []\n" : "\n");
  for (const PlannedObject& object : scene.objects) AppendObject(object, yaml);
  return yaml;
}

}  // namespace cwm::server
