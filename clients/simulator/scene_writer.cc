#include <cctype>
#include <filesystem>
#include <utility>

#include <yaml-cpp/yaml.h>

#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/ply.h"
#include "clients/formats/scalar.h"
#include "clients/simulator/scene_file.h"

namespace cwm::simulator {
namespace {

using perception::Finish;
using perception::PieceRole;
using perception::PinholeCamera;
using perception::SimulatedObject;
using perception::SimulatedView;

std::string Text(double value) { return formats::FormatNumber(value); }

template <class Numbers>
void EmitList(YAML::Emitter& out, const Numbers& numbers) {
  out << YAML::Flow << YAML::BeginSeq;
  for (const double number : numbers) out << Text(number);
  out << YAML::EndSeq;
}

void EmitNumber(YAML::Emitter& out, const char* key, double value) {
  out << YAML::Key << key << YAML::Value << Text(value);
}

void EmitPolygon(YAML::Emitter& out, const Polygon& polygon) {
  out << YAML::Flow << YAML::BeginSeq;
  for (const Vector2& vertex : polygon) EmitList(out, vertex);
  out << YAML::EndSeq;
}

void EmitPose(YAML::Emitter& out, const Pose& pose) {
  const Quaternion q(pose.linear());
  out << YAML::Key << "pose" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "position_m" << YAML::Value;
  EmitList(out, pose.translation());
  out << YAML::Key << "quaternion_xyzw" << YAML::Value;
  EmitList(out, q.coeffs());  // Eigen's order is x y z w
  out << YAML::EndMap;
}

formats::MeshFile ToFile(const TriangleMesh& mesh) {
  formats::MeshFile file;
  for (const Vector3& p : mesh.vertices) file.vertices.push_back({p.x(), p.y(), p.z()});
  file.triangles = mesh.triangles;
  return file;
}

// Writes the members of a shape's map. Meshes are written to `mesh_path`.
struct EmitDimensions {
  YAML::Emitter& out;
  std::filesystem::path mesh_path;

  absl::Status operator()(const Sphere& sphere) const {
    EmitNumber(out, "radius_m", sphere.radius_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const Box& box) const {
    out << YAML::Key << "size_m" << YAML::Value;
    EmitList(out, box.size_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const Cylinder& cylinder) const {
    EmitNumber(out, "radius_m", cylinder.radius_m);
    EmitNumber(out, "length_m", cylinder.length_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const Cone& cone) const {
    EmitNumber(out, "radius_bottom_m", cone.radius_bottom_m);
    EmitNumber(out, "radius_top_m", cone.radius_top_m);
    EmitNumber(out, "length_m", cone.length_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const Capsule& capsule) const {
    EmitNumber(out, "radius_m", capsule.radius_m);
    EmitNumber(out, "length_m", capsule.length_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const HalfSpace&) const { return absl::OkStatus(); }
  absl::Status operator()(const Plate& plate) const {
    out << YAML::Key << "outline_m" << YAML::Value;
    EmitPolygon(out, plate.outline);
    if (!plate.holes.empty()) {
      out << YAML::Key << "holes_m" << YAML::Value << YAML::BeginSeq;
      for (const Polygon& hole : plate.holes) EmitPolygon(out, hole);
      out << YAML::EndSeq;
    }
    EmitNumber(out, "thickness_m", plate.thickness_m);
    return absl::OkStatus();
  }
  absl::Status operator()(const Convex& convex) const { return EmitMesh(*convex.hull); }
  absl::Status operator()(const Mesh& mesh) const { return EmitMesh(*mesh.mesh); }

  absl::Status EmitMesh(const TriangleMesh& mesh) const {
    out << YAML::Key << "file" << YAML::Value << YAML::DoubleQuoted
        << mesh_path.filename().string();
    return formats::WriteFileBytes(mesh_path.string(), formats::FormatPlyMesh(ToFile(mesh)));
  }
};

// Hulls are written as meshes.
std::string KeyOf(const Shape& shape) {
  const ShapeKind kind = KindOf(shape);
  return std::string(cwm::NameOf(kind == ShapeKind::kConvex ? ShapeKind::kMesh : kind));
}

void EmitCamera(YAML::Emitter& out, const PinholeCamera& camera) {
  out << YAML::Key << "camera" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "width" << YAML::Value << camera.width;
  out << YAML::Key << "height" << YAML::Value << camera.height;
  EmitNumber(out, "focal_px", camera.focal_px);
  out << YAML::Key << "center_px" << YAML::Value;
  EmitList(out, Vector2(camera.center_x_px, camera.center_y_px));
  EmitPose(out, camera.X_WC);
  out << YAML::EndMap;
}

// Replaces characters of an object's name that may not be valid in a file name.
std::string FileWord(std::string name) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

absl::Status EmitObject(YAML::Emitter& out, const SimulatedObject& object,
                        const std::filesystem::path& mesh_stem) {
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << object.name;
  if (object.is_support) out << YAML::Key << "support" << YAML::Value << true;
  if (object.finish == Finish::kShiny) out << YAML::Key << "shiny" << YAML::Value << true;
  EmitPose(out, object.X_WO);
  out << YAML::Key << "parts" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < object.parts.size(); ++i) {
    const Placed<>& part = object.parts[i];
    const auto mesh_path = absl::StrCat(mesh_stem.string(), "_", i, ".ply");
    out << YAML::BeginMap << YAML::Key << KeyOf(part.shape) << YAML::Value << YAML::BeginMap;
    absl::Status status =
        std::visit(EmitDimensions{.out = out, .mesh_path = mesh_path}, part.shape);
    if (!status.ok()) return status;
    out << YAML::EndMap;
    EmitPose(out, part.X_FS);
    if (object.RoleOf(i) != PieceRole::kBody) {
      out << YAML::Key << "role" << YAML::Value << std::string(PieceRoleName(object.RoleOf(i)));
    }
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return absl::OkStatus();
}

}  // namespace

std::string_view PieceRoleName(PieceRole role) {
  switch (role) {
    case PieceRole::kBody:
      return "body";
    case PieceRole::kHandle:
      return "handle";
    case PieceRole::kSpout:
      return "spout";
  }
  return "body";
}

absl::Status WriteScene(const std::string& path, const SimulatedView& view) {
  const std::filesystem::path stem = std::filesystem::path(path).replace_extension();
  YAML::Emitter out;
  out << YAML::BeginMap;
  EmitCamera(out, view.camera);
  out << YAML::Key << "objects" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < view.scene.objects.size(); ++i) {
    const SimulatedObject& object = view.scene.objects[i];
    const auto mesh_stem = absl::StrCat(stem.string(), "_", i, "_", FileWord(object.name));
    absl::Status status = EmitObject(out, object, mesh_stem);
    if (!status.ok()) return status;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return formats::WriteFileBytes(path, absl::StrCat(out.c_str(), "\n"));
}

}  // namespace cwm::simulator
