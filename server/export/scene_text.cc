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
  std::string& text;

  // Radius before length, unlike shape_msgs/SolidPrimitive.
  void operator()(const PlannerPrimitive& s) const {
    const auto& d = s.dimensions_m;
    switch (s.kind) {
      case PlannerPrimitive::Kind::kBox:
        absl::StrAppend(&text, "box\n", Text({d[0], d[1], d[2]}, " "), "\n");
        return;
      case PlannerPrimitive::Kind::kSphere:
        absl::StrAppend(&text, "sphere\n", NumberText(d[0]), "\n");
        return;
      case PlannerPrimitive::Kind::kCylinder:
        absl::StrAppend(&text, "cylinder\n", NumberText(d[1]), " ", NumberText(d[0]), "\n");
        return;
      case PlannerPrimitive::Kind::kCone:
        absl::StrAppend(&text, "cone\n", NumberText(d[1]), " ", NumberText(d[0]), "\n");
        return;
    }
  }
  void operator()(const PlannerMesh& mesh) const {
    absl::StrAppend(&text, "mesh\n", mesh->vertices.size(), " ", mesh->triangles.size(), "\n");
    for (const Vector3& vertex : mesh->vertices) absl::StrAppend(&text, Text(vertex, " "), "\n");
    for (const auto& [a, b, c] : mesh->triangles) absl::StrAppend(&text, a, " ", b, " ", c, "\n");
  }
  void operator()(const PlannerPlane&) const { absl::StrAppend(&text, "plane\n0 0 1 0\n"); }
};

}  // namespace

absl::StatusOr<std::string> FormatSceneText(const PlanningScene& scene, const GoOn& go_on) {
  std::string text = absl::StrCat(scene.name, "\n");
  for (const PlannedObject& object : scene.objects) {
    if (absl::Status status = go_on(); !status.ok()) return status;
    absl::StrAppend(&text, "* ", object.name, "\n");
    AppendPose(object.X_WO, text);
    absl::StrAppend(&text, object.shapes.size(), "\n");
    for (const PlannerShape& shape : object.shapes) {
      std::visit(ShapeWriter{text}, shape.shape);
      AppendPose(shape.X_OS, text);
      absl::StrAppend(&text, "0 0 0 0\n");  // no colour
    }
    absl::StrAppend(&text, "0\n");  // no subframes
  }
  text += ".\n";  // not `text + ..`, which would copy all of it
  return text;
}

}  // namespace cwm::server
