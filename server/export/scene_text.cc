// The ".scene" format; declared in moveit_scene.h.
#include "absl/strings/str_cat.h"
#include "server/export/moveit_scene.h"
#include "server/export/scene_numbers.h"

namespace cwm::server {
namespace {

void AppendPose(const Pose& pose, std::string& text) {
  absl::StrAppend(&text, Text(pose.translation(), " "), "\n", RotationText(pose, " "), "\n");
}

struct ShapeWriter {
  const CancellationCheck& check_cancelled;
  std::string& text;

  // Radius before length, unlike shape_msgs/SolidPrimitive.
  absl::Status operator()(const PlannerPrimitive& s) const {
    const auto& d = s.dimensions_m;
    switch (s.kind) {
      case PlannerPrimitive::Kind::kBox:
        absl::StrAppend(&text, "box\n", Text({d[0], d[1], d[2]}, " "), "\n");
        break;
      case PlannerPrimitive::Kind::kSphere:
        absl::StrAppend(&text, "sphere\n", NumberText(d[0]), "\n");
        break;
      case PlannerPrimitive::Kind::kCylinder:
        absl::StrAppend(&text, "cylinder\n", NumberText(d[1]), " ", NumberText(d[0]), "\n");
        break;
      case PlannerPrimitive::Kind::kCone:
        absl::StrAppend(&text, "cone\n", NumberText(d[1]), " ", NumberText(d[0]), "\n");
        break;
    }
    return absl::OkStatus();
  }
  absl::Status operator()(const PlannerMesh& mesh) const {
    absl::StrAppend(&text, "mesh\n", mesh->vertices.size(), " ", mesh->triangles.size(), "\n");
    const auto append_vertices = [&](std::size_t v, std::size_t end) {
      for (; v < end; ++v) absl::StrAppend(&text, Text(mesh->vertices[v], " "), "\n");
    };
    absl::Status status = ForEachRange(mesh->vertices.size(), check_cancelled, append_vertices);
    if (!status.ok()) return status;
    return ForEachRange(mesh->triangles.size(), check_cancelled,
                        [&](std::size_t t, std::size_t end) {
                          for (; t < end; ++t) {
                            const auto& [a, b, c] = mesh->triangles[t];
                            absl::StrAppend(&text, a, " ", b, " ", c, "\n");
                          }
                        });
  }
  absl::Status operator()(const PlannerPlane&) const {
    absl::StrAppend(&text, "plane\n0 0 1 0\n");
    return absl::OkStatus();
  }
};

}  // namespace

absl::StatusOr<std::string> FormatSceneText(const PlanningScene& scene,
                                            const CancellationCheck& check_cancelled) {
  std::string text = absl::StrCat(scene.name, "\n");
  for (const PlannedObject& object : scene.objects) {
    if (absl::Status status = check_cancelled(); !status.ok()) return status;
    absl::StrAppend(&text, "* ", object.name, "\n");
    AppendPose(object.X_WO, text);
    absl::StrAppend(&text, object.shapes.size(), "\n");
    for (const PlannerShape& shape : object.shapes) {
      absl::Status status = std::visit(ShapeWriter{check_cancelled, text}, shape.shape);
      if (!status.ok()) return status;
      AppendPose(shape.X_OS, text);
      absl::StrAppend(&text, "0 0 0 0\n");  // no colour
    }
    absl::StrAppend(&text, "0\n");  // no subframes
  }
  text += ".\n";  // `text + ..` would copy all of it
  return text;
}

}  // namespace cwm::server
