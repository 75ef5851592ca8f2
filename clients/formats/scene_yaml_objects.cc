// Objects of a planning scene in YAML (moveit_msgs/CollisionObject).
#include <cstring>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"
#include "clients/formats/scene_shapes.h"
#include "clients/formats/scene_yaml.h"

namespace cwm::formats {
namespace {

class ObjectReader {
 public:
  ObjectReader(const FieldReader& reader, SceneObject& object, std::vector<std::string>& warnings)
      : reader_(reader), object_(object), warnings_(warnings) {}

  absl::Status Read(const YamlNode& node) {
    auto status = ReadList(node, "primitives", "primitive_poses", &ObjectReader::ReadPrimitive);
    if (!status.ok()) return status;
    status = ReadList(node, "meshes", "mesh_poses", &ObjectReader::ReadMesh);
    if (!status.ok()) return status;
    return ReadList(node, "planes", "plane_poses", &ObjectReader::ReadPlane);
  }

 private:
  using ReadShape = absl::Status (ObjectReader::*)(const YamlNode& node, SceneShape& shape);

  // Reads a list of shapes and a list of as many poses.
  absl::Status ReadList(const YamlNode& node, const char* shapes_key, const char* poses_key,
                        ReadShape read) {
    const YamlNode shapes = node[shapes_key];
    const YamlNode poses = node[poses_key];
    for (const YamlNode& list : {shapes, poses}) {
      if (absl::Status status = reader_.CheckList(list); !status.ok()) return status;
    }
    if (shapes.size() != poses.size()) {
      return reader_.Error(poses, absl::StrCat("must hold a pose for each of ", shapes.size(), " ",
                                               shapes_key, ", holds ", poses.size()));
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      SceneShape shape;
      const auto pose = reader_.Pose(poses[i]);
      if (!pose.ok()) return pose.status();
      shape.pose = *pose;
      if (absl::Status status = (this->*read)(shapes[i], shape); !status.ok()) return status;
      object_.shapes.push_back(std::move(shape));
    }
    return absl::OkStatus();
  }

  absl::Status ReadPrimitive(const YamlNode& node, SceneShape& shape) {
    const YamlNode type = node["type"];
    const PrimitiveKind* kind = FindPrimitive(type.is_scalar() ? type.yaml.Scalar() : "");
    if (kind == nullptr) return reader_.Error(type, "must be box, sphere, cylinder or cone");
    // Some writers pad every list to three numbers with zeros.
    const YamlNode list = node["dimensions"];
    const std::size_t count = kind->dimension_count;
    const bool is_padded = list.size() == 3 && count < 3;
    auto dimensions = reader_.Numbers(list, is_padded ? 3 : count);
    if (!dimensions.ok()) return dimensions.status();
    for (std::size_t i = count; i < dimensions->size(); ++i) {
      if ((*dimensions)[i] == 0) continue;
      return reader_.Error(list, absl::StrCat("must be a list of ", count, " numbers"));
    }
    for (std::size_t i = 0; i < count; ++i) {
      if ((*dimensions)[i] <= 0) return reader_.Error(list[i], "must be positive");
    }
    shape.shape = MakePrimitive(*kind, *dimensions);
    return absl::OkStatus();
  }

  absl::Status ReadMesh(const YamlNode& node, SceneShape& shape) {
    if (node["resource"].present()) {
      return reader_.Error(node["resource"],
                           "must be absent: only meshes with vertices and triangles are read");
    }
    MeshFile mesh;
    const YamlNode vertices = node["vertices"];
    const YamlNode triangles = node["triangles"];
    for (const YamlNode& list : {vertices, triangles}) {
      if (!list.is_list()) return reader_.Error(list, "must be a list");
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto p = reader_.Vector(vertices[i], {"x", "y", "z"});
      if (!p.ok()) return p.status();
      mesh.vertices.push_back({(*p)[0], (*p)[1], (*p)[2]});
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const YamlNode entry = triangles[i];
      if (auto status = ReadTriangle(entry.is_map() ? entry["vertex_indices"] : entry, mesh);
          !status.ok()) {
        return status;
      }
    }
    const std::size_t dropped = RemoveDegenerateTriangles(mesh);
    if (mesh.triangles.empty()) {
      return reader_.Error(triangles, "must hold a triangle of three different vertices");
    }
    if (dropped > 0) {
      warnings_.push_back(absl::StrCat(Printable(object_.id), ": ", dropped,
                                       " triangles that use a vertex twice are left out"));
    }
    shape.shape = std::move(mesh);
    return absl::OkStatus();
  }

  absl::Status ReadTriangle(const YamlNode& node, MeshFile& mesh) {
    if (node.size() != 3) return reader_.Error(node, "must be a list of 3 indices");
    std::array<std::uint32_t, 3> triangle = {};
    for (std::size_t i = 0; i < 3; ++i) {
      const YamlNode corner = node[i];
      const auto word = reader_.Scalar(corner);
      if (!word.ok()) return word.status();
      char bytes[sizeof(std::uint32_t)];
      if (ParseScalar(*word, Scalar::kU32, bytes)) {
        std::memcpy(&triangle[i], bytes, sizeof(bytes));
        if (triangle[i] < mesh.vertices.size()) continue;
      }
      return reader_.Error(corner,
                           absl::StrCat("must be an index of ", mesh.vertices.size(), " vertices"));
    }
    mesh.triangles.push_back(triangle);
    return absl::OkStatus();
  }

  absl::Status ReadPlane(const YamlNode& node, SceneShape& shape) {
    const auto abcd = reader_.Numbers(node["coef"], 4);
    if (!abcd.ok()) return abcd.status();
    const std::array<double, 4> plane = {(*abcd)[0], (*abcd)[1], (*abcd)[2], (*abcd)[3]};
    if (plane[0] == 0 && plane[1] == 0 && plane[2] == 0) {
      return reader_.Error(node["coef"], "must have a normal that is not 0");
    }
    shape.pose = ComposePoses(shape.pose, PlaneFrame(plane));
    shape.shape = SceneHalfSpace{};
    return absl::OkStatus();
  }

  const FieldReader& reader_;
  SceneObject& object_;
  std::vector<std::string>& warnings_;
};

}  // namespace

// The operation as a number of moveit_msgs/CollisionObject or as a word; the default is "add". Only
// adding and removing are supported.
absl::StatusOr<SceneOperation> ReadOperation(const FieldReader& reader, const YamlNode& node,
                                             SceneKind kind) {
  if (!node.present()) return SceneOperation::kAdd;
  const std::string word = node.is_scalar() ? absl::AsciiStrToLower(node.yaml.Scalar()) : "";
  if (word == "add" || word == "0" || word == std::string(1, '\0')) return SceneOperation::kAdd;
  if (kind == SceneKind::kFull) {
    return reader.Error(node, "must be add: only a scene with is_diff: true takes away");
  }
  if (word == "remove" || word == "1" || word == std::string(1, '\1')) {
    return SceneOperation::kRemove;
  }
  return reader.Error(node, "must be add or remove");
}

absl::StatusOr<SceneObject> ReadObject(const FieldReader& reader, const YamlNode& node,
                                       std::vector<std::string>& warnings) {
  SceneObject object;
  auto id = reader.Name(node["id"]);
  if (!id.ok()) return id.status();
  object.id = *std::move(id);
  const auto operation = ReadOperation(reader, node["operation"], SceneKind::kFull);
  if (!operation.ok()) return operation.status();
  if (node["pose"].present()) {
    const auto pose = reader.Pose(node["pose"]);
    if (!pose.ok()) return pose.status();
    object.pose = *pose;
  }
  const absl::Status status = ObjectReader(reader, object, warnings).Read(node);
  if (!status.ok()) return status;
  return object;
}

}  // namespace cwm::formats
