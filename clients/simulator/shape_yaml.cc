#include "clients/simulator/shape_yaml.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/meshes/mesh_reading.h"
#include "collision/geometry/validation.h"

namespace cwm::simulator {
namespace {

// The numbers under these keys; all of them are required, and no others are allowed.
absl::StatusOr<std::vector<double>> ReadFields(const YamlNode& node,
                                               std::initializer_list<std::string_view> keys) {
  if (absl::Status status = node.CheckKeys(keys); !status.ok()) return status;
  std::vector<double> values;
  for (const std::string_view key : keys) {
    const auto value = node[key].ReadNumber();
    if (!value.ok()) return value.status();
    values.push_back(*value);
  }
  return values;
}

using ReadShapeFunction = absl::StatusOr<Shape> (*)(const YamlNode&);

absl::StatusOr<Shape> ReadSphere(const YamlNode& node) {
  const auto values = ReadFields(node, {"radius_m"});
  if (!values.ok()) return values.status();
  return Sphere{.radius_m = (*values)[0]};
}

absl::StatusOr<Shape> ReadBox(const YamlNode& node) {
  if (absl::Status status = node.CheckKeys({"size_m"}); !status.ok()) return status;
  const auto size = node["size_m"].ReadNumbers(3);
  if (!size.ok()) return size.status();
  return Box{.size_m = {(*size)[0], (*size)[1], (*size)[2]}};
}

absl::StatusOr<Shape> ReadCylinder(const YamlNode& node) {
  const auto values = ReadFields(node, {"radius_m", "length_m"});
  if (!values.ok()) return values.status();
  return Cylinder{.radius_m = (*values)[0], .length_m = (*values)[1]};
}

absl::StatusOr<Shape> ReadCone(const YamlNode& node) {
  const auto values = ReadFields(node, {"radius_bottom_m", "radius_top_m", "length_m"});
  if (!values.ok()) return values.status();
  return Cone{
      .radius_bottom_m = (*values)[0], .radius_top_m = (*values)[1], .length_m = (*values)[2]};
}

absl::StatusOr<Shape> ReadCapsule(const YamlNode& node) {
  const auto values = ReadFields(node, {"radius_m", "length_m"});
  if (!values.ok()) return values.status();
  return Capsule{.radius_m = (*values)[0], .length_m = (*values)[1]};
}

absl::StatusOr<Shape> ReadHalfSpace(const YamlNode& node) {
  if (absl::Status status = node.CheckKeys({}); !status.ok()) return status;
  return HalfSpace{};
}

absl::StatusOr<Polygon> ReadPolygon(const YamlNode& node) {
  if (!node.is_list()) return node.Error("must be a list of [x, y]");
  Polygon polygon;
  for (std::size_t i = 0; i < node.size(); ++i) {
    const auto vertex = node[i].ReadNumbers(2);
    if (!vertex.ok()) return vertex.status();
    polygon.emplace_back((*vertex)[0], (*vertex)[1]);
  }
  return polygon;
}

absl::StatusOr<Shape> ReadPlate(const YamlNode& node) {
  if (absl::Status status = node.CheckKeys({"outline_m", "holes_m", "thickness_m"}); !status.ok()) {
    return status;
  }
  const auto outline = ReadPolygon(node["outline_m"]);
  if (!outline.ok()) return outline.status();
  const auto thickness = node["thickness_m"].ReadNumber();
  if (!thickness.ok()) return thickness.status();
  Plate plate{.outline = *outline, .holes = {}, .thickness_m = *thickness};
  const YamlNode holes = node["holes_m"];
  if (holes.present() && !holes.is_list()) return holes.Error("must be a list of polygons");
  for (std::size_t i = 0; i < holes.size(); ++i) {
    const auto hole = ReadPolygon(holes[i]);
    if (!hole.ok()) return hole.status();
    plate.holes.push_back(*hole);
  }
  return plate;
}

absl::StatusOr<Shape> ReadMeshFile(const YamlNode& node) {
  if (absl::Status status = node.CheckKeys({"file", "scale"}); !status.ok()) return status;
  const auto name = node["file"].ReadText();
  if (!name.ok()) return name.status();
  double scale = 1;
  if (node["scale"].present()) {
    const auto factor = node["scale"].ReadNumber();
    if (!factor.ok()) return factor.status();
    if (*factor <= 0) return node["scale"].Error("must be positive");
    scale = *factor;
  }
  const auto path = std::filesystem::path(node.file()).parent_path() / *name;
  auto mesh = meshes::ReadMesh(path.string());
  if (!mesh.ok())
    return node["file"].Error(
        absl::StrCat("cannot be used: ", std::string(mesh.status().message())));
  for (Vector3& vertex : mesh->vertices) vertex *= scale;
  return MakeMesh(*std::move(mesh));
}

// In the order of kShapeKeys.
constexpr std::array<ReadShapeFunction, kShapeKeys.size()> kReaders = {
    ReadSphere,  ReadBox,   ReadCylinder,  ReadCone,
    ReadCapsule, ReadPlate, ReadHalfSpace, ReadMeshFile};

// The place of a violation's field, such as "radius_m" or "outline[3].x", in the scene file.
YamlNode FieldOf(const YamlNode& node, const std::string& field) {
  const std::string key = field.substr(0, field.find_first_of(".["));
  if (node[key].present()) return node[key];
  return node[key + "_m"].present() ? node[key + "_m"] : node;
}

}  // namespace

absl::StatusOr<Shape> ReadShape(const YamlNode& node, std::string_view key) {
  const YamlNode dimensions = node[key];
  const auto kind = std::find(kShapeKeys.begin(), kShapeKeys.end(), key) - kShapeKeys.begin();
  auto shape = kReaders[static_cast<std::size_t>(kind)](dimensions);
  if (!shape.ok()) return shape.status();
  if (const auto violation = FindViolation(*shape)) {
    return FieldOf(dimensions, violation->field)
        .Error(absl::StrCat(violation->rule, "; ", violation->field, " is ", violation->value));
  }
  return shape;
}

}  // namespace cwm::simulator
