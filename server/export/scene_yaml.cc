// moveit_msgs/PlanningScene in YAML; declared in moveit_scene.h.
#include <functional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/export/moveit_scene.h"
#include "server/export/scene_numbers.h"

namespace cwm::server {
namespace {

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

absl::StatusOr<std::string> MeshText(const TriangleMesh& mesh,
                                     const CancellationCheck& check_cancelled) {
  std::string text = "{vertices: [";
  const auto append_vertices = [&](std::size_t i, std::size_t end) {
    for (; i < end; ++i) {
      absl::StrAppend(&text, i == 0 ? "[" : ", [", Text(mesh.vertices[i], ", "), "]");
    }
  };
  absl::Status status = ForEachRange(mesh.vertices.size(), check_cancelled, append_vertices);
  if (!status.ok()) return status;
  absl::StrAppend(&text, "], triangles: [");
  const auto append_triangles = [&](std::size_t i, std::size_t end) {
    for (; i < end; ++i) {
      const auto& [a, b, c] = mesh.triangles[i];
      absl::StrAppend(&text, i == 0 ? "[" : ", [", a, ", ", b, ", ", c, "]");
    }
  };
  status = ForEachRange(mesh.triangles.size(), check_cancelled, append_triangles);
  if (!status.ok()) return status;
  text += "]}";  // `text + ..` would copy all of it
  return text;
}

// Writes an object in its frame F, each key after `indent`.
class ObjectWriter {
 public:
  ObjectWriter(const PlannedObject& object, const Pose& X_FO, std::string indent,
               const CancellationCheck& check_cancelled, std::string& yaml)
      : object_(object),
        X_FO_(X_FO),
        indent_(std::move(indent)),
        check_cancelled_(check_cancelled),
        yaml_(yaml) {}

  // An object of a single shape is written with the shape's pose only, so that all versions read
  // it, including those before objects had poses.
  absl::Status Write() {
    if (object_.shapes.size() == 1) {
      X_FS_ = X_FO_;
    } else {
      absl::StrAppend(&yaml_, indent_, "pose: ", PoseText(X_FO_), "\n");
    }
    absl::Status status =
        WriteShapes<PlannerPrimitive>("primitives", "primitive_poses", PrimitiveText);
    if (!status.ok()) return status;
    status = WriteShapes<PlannerMesh>("meshes", "mesh_poses", [this](const PlannerMesh& mesh) {
      return MeshText(*mesh, check_cancelled_);
    });
    if (!status.ok()) return status;
    return WriteShapes<PlannerPlane>("planes", "plane_poses", [](const PlannerPlane&) {
      return std::string("{coef: [0, 0, 1, 0]}");
    });
  }

 private:
  // The shapes of one kind and their poses, as two lists.
  template <class T>
  absl::Status WriteShapes(const char* shapes_key, const char* poses_key,
                           const std::function<absl::StatusOr<std::string>(const T&)>& say) {
    std::string shapes, poses;
    for (const PlannerShape& shape : object_.shapes) {
      const T* typed = std::get_if<T>(&shape.shape);
      if (typed == nullptr) continue;
      const absl::StatusOr<std::string> said = say(*typed);
      if (!said.ok()) return said.status();
      absl::StrAppend(&shapes, indent_, "  - ", *said, "\n");
      absl::StrAppend(&poses, indent_, "  - ", PoseText(X_FS_ * shape.X_OS), "\n");
    }
    if (shapes.empty()) return absl::OkStatus();
    absl::StrAppend(&yaml_, indent_, shapes_key, ":\n", shapes, indent_, poses_key, ":\n", poses);
    return check_cancelled_();
  }

  const PlannedObject& object_;
  const Pose X_FO_;
  const std::string indent_;
  const CancellationCheck& check_cancelled_;
  std::string& yaml_;
  Pose X_FS_ = Pose::Identity();  // transform before the poses of the shapes
};

absl::Status AppendObject(const PlannedObject& object, const CancellationCheck& check_cancelled,
                          std::string& yaml) {
  absl::StrAppend(&yaml, "    - id: ", Quoted(object.name), "\n");
  return ObjectWriter(object, object.X_WO, "      ", check_cancelled, yaml).Write();
}

// Attached objects are written in the frame of their link, as MoveIt expects.
absl::Status AppendAttached(const PlannedObject& object, const CancellationCheck& check_cancelled,
                            std::string& yaml) {
  const PlannedAttachment& attachment = *object.attachment;
  absl::StrAppend(&yaml, "    - link_name: ", Quoted(attachment.link),
                  "\n      touch_links: ", Names(attachment.touch_links),
                  "\n      object:\n        header: {frame_id: ", Quoted(attachment.link),
                  "}\n        id: ", Quoted(object.name), "\n");
  return ObjectWriter(object, attachment.X_LO, "        ", check_cancelled, yaml).Write();
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

absl::Status AppendMatrix(const AllowedCollisionMatrix& matrix,
                          const CancellationCheck& check_cancelled, std::string& yaml) {
  absl::StrAppend(&yaml, "allowed_collision_matrix:\n  entry_names: ", Names(matrix.names),
                  "\n  entry_values:\n");
  for (const std::vector<bool>& row : matrix.allowed) {
    if (absl::Status status = check_cancelled(); !status.ok()) return status;
    yaml += "    - [";
    for (std::size_t i = 0; i < row.size(); ++i) {
      absl::StrAppend(&yaml, i == 0 ? "" : ", ", row[i] ? "true" : "false");
    }
    yaml += "]\n";
  }
  if (matrix.by_default.empty()) return absl::OkStatus();
  const std::vector<std::string> values(matrix.by_default.size(), "true");
  absl::StrAppend(&yaml, "  default_entry_names: ", Names(matrix.by_default),
                  "\n  default_entry_values: [", absl::StrJoin(values, ", "), "]\n");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> FormatSceneYaml(const PlanningScene& scene,
                                            const CancellationCheck& check_cancelled) {
  std::string yaml = absl::StrCat("name: ", Quoted(scene.name), "\n");
  if (!scene.robot_name.empty()) {
    absl::StrAppend(&yaml, "robot_model_name: ", Quoted(scene.robot_name), "\n");
    AppendState(scene.robot_state, yaml);
    const char* key = "  attached_collision_objects:\n";
    for (const PlannedObject& object : scene.objects) {
      if (!object.attachment) continue;
      yaml += std::exchange(key, "");
      if (auto status = AppendAttached(object, check_cancelled, yaml); !status.ok()) return status;
    }
  }
  absl::StrAppend(&yaml, "fixed_frame_transforms:\n  - child_frame_id: world\n    transform: ",
                  TransformText(Pose::Identity()), "\n");
  if (!scene.allowed.names.empty()) {
    if (auto status = AppendMatrix(scene.allowed, check_cancelled, yaml); !status.ok())
      return status;
  }
  yaml += "world:\n  collision_objects:";
  const std::size_t none = yaml.size();
  for (const PlannedObject& object : scene.objects) {
    if (object.attachment) continue;
    if (yaml.size() == none) yaml += "\n";
    if (absl::Status status = AppendObject(object, check_cancelled, yaml); !status.ok())
      return status;
  }
  if (yaml.size() == none) yaml += " []\n";
  return yaml;
}

}  // namespace cwm::server
