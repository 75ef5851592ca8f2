// Binary glTF 2.0; declared in drawn_world.h. Section numbers refer to its specification.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "proto/transfer/glb_format.h"
#include "proto/transfer/glb_writer.h"
#include "server/export/drawn_world.h"
#include "server/export/file_bytes.h"

namespace cwm::server {
namespace {

using Json = nlohmann::ordered_json;

// Colours are given in sRGB; factors of materials are linear (section 3.9.2).
double Linear(std::uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

Json MaterialOf(MaterialKind material, bool is_closed) {
  const auto [red, green, blue, opacity] = ColourOf(material);
  Json json = {{"name", std::string(NameOf(material)) + (is_closed ? "" : ", open")},
               {"pbrMetallicRoughness",
                {{"baseColorFactor", {Linear(red), Linear(green), Linear(blue), opacity / 255.0}},
                 {"metallicFactor", 0},
                 {"roughnessFactor", 0.8}}}};
  if (opacity < 255) json["alphaMode"] = "BLEND";
  if (!is_closed) json["doubleSided"] = true;
  return json;
}

// A JSON array as text, which takes a tenth of the memory and is joined quickly.
class JsonList {
 public:
  // Returns the index of the new element.
  std::size_t Add(const Json& element) {
    absl::StrAppend(&text_, text_.empty() ? "" : ",", element.dump());
    return size_++;
  }
  std::size_t size() const { return size_; }
  std::string Text() const { return absl::StrCat("[", text_, "]"); }

 private:
  std::string text_;
  std::size_t size_ = 0;
};

// The JSON and the binary buffer that it refers to.
class Document {
 public:
  Document(const std::string& name, const CancellationCheck& check_cancelled)
      : check_cancelled_(check_cancelled) {
    // A rotation by -90 degrees about x: the world's Z becomes glTF's Y.
    AddParent({{"name", name}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}});
  }

  // Adds a node below the root, or below the robot that was added last.
  absl::Status Add(const DrawnItem& item) {
    if (!item.robot.empty() && robot_ != item.robot) AddRobot(item.robot);
    const auto mesh = MeshOf(item.body.get());
    if (!mesh.ok()) return mesh.status();
    Json node = {{"name", item.name}, {"mesh", *mesh}};
    Place(item.X_WB, node);
    for (const auto& [name, value] : item.properties) node["extras"][name] = value;
    Parent& parent = item.robot.empty() ? parents_.front() : parents_.back();
    parent.children.push_back(nodes_.size());
    nodes_.push_back(node.dump());
    return check_cancelled_();
  }

  absl::StatusOr<std::string> Finish() {
    for (Parent& parent : parents_) {
      if (!parent.children.empty()) parent.node["children"] = std::move(parent.children);
      nodes_[parent.index] = parent.node.dump();
    }
    std::string json = absl::StrCat(
        R"({"asset":{"version":"2.0","generator":"cwm"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)",
        absl::StrJoin(nodes_, ","), "]");
    nodes_.clear();
    if (meshes_.size() > 0) {  // glTF allows no empty array
      absl::StrAppend(&json, ",\"meshes\":", meshes_.Text(), ",\"materials\":", materials_.Text());
      absl::StrAppend(&json, ",\"accessors\":", accessors_.Text(),
                      ",\"bufferViews\":", views_.Text());
      absl::StrAppend(&json, ",\"buffers\":[{\"byteLength\":", binary_.size(), "}]");
    }
    json += "}";
    if (absl::Status status = check_cancelled_(); !status.ok()) return status;
    return JoinGlb(json, binary_);
  }

 private:
  // A node with children; the first is the root.
  struct Parent {
    std::size_t index = 0;  // index of the node
    Json node;
    std::vector<std::size_t> children = {};
  };

  static void Place(const Pose& X_WB, Json& node) {
    const Quaternion q = Quaternion(X_WB.linear()).normalized();
    const Vector3& p = X_WB.translation();
    node["translation"] = {p.x(), p.y(), p.z()};
    node["rotation"] = {q.x(), q.y(), q.z(), q.w()};
  }

  void AddParent(Json node) {
    parents_.push_back({.index = nodes_.size(), .node = std::move(node)});
    nodes_.emplace_back();  // written when its children are known
  }

  void AddRobot(const std::string& name) {
    robot_ = name;
    parents_.front().children.push_back(nodes_.size());
    AddParent({{"name", name}});
  }

  absl::StatusOr<std::size_t> MeshOf(const DrawnBody* body) {
    const auto [at, is_new] = mesh_of_.try_emplace(body, meshes_.size());
    if (!is_new) return at->second;
    Json primitives = Json::array();
    for (const DrawnMesh& piece : *body) {
      const auto positions = Positions(piece.mesh);
      if (!positions.ok()) return positions.status();
      const auto indices = Indices(piece.mesh);
      if (!indices.ok()) return indices.status();
      primitives.push_back({{"attributes", {{"POSITION", *positions}}},
                            {"indices", *indices},
                            {"material", MaterialIndex(piece.material, piece.is_closed)}});
    }
    return meshes_.Add({{"primitives", std::move(primitives)}});
  }

  std::size_t MaterialIndex(MaterialKind material, bool is_closed) {
    const auto [at, is_new] = material_index_.try_emplace({material, is_closed}, materials_.size());
    if (is_new) materials_.Add(MaterialOf(material, is_closed));
    return at->second;
  }

  absl::StatusOr<std::size_t> Positions(const TriangleMesh& mesh) {
    const std::size_t begin = binary_.size();
    std::array<float, 3> min{}, max{};
    const auto append = [&](std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v) {
        for (std::size_t i = 0; i < 3; ++i) {
          const auto value = static_cast<float>(mesh.vertices[v][static_cast<int>(i)]);
          min[i] = v == 0 ? value : std::min(min[i], value);
          max[i] = v == 0 ? value : std::max(max[i], value);
          AppendBytes(value, binary_);
        }
      }
    };
    absl::Status status = ForEachRange(mesh.vertices.size(), check_cancelled_, append);
    if (!status.ok()) return status;
    return AddAccessor(begin, kGltfArrayBuffer,
                       {{"componentType", kGltfFloat},
                        {"type", "VEC3"},
                        {"count", mesh.vertices.size()},
                        {"min", min},
                        {"max", max}});
  }

  absl::StatusOr<std::size_t> Indices(const TriangleMesh& mesh) {
    const std::size_t begin = binary_.size();
    const auto append = [&](std::size_t first, std::size_t last) {
      for (std::size_t t = first; t < last; ++t) {
        for (const std::uint32_t vertex : mesh.triangles[t]) AppendBytes(vertex, binary_);
      }
    };
    absl::Status status = ForEachRange(mesh.triangles.size(), check_cancelled_, append);
    if (!status.ok()) return status;
    return AddAccessor(begin, kGltfElementArrayBuffer,
                       {{"componentType", kGltfUnsignedInt},
                        {"type", "SCALAR"},
                        {"count", 3 * mesh.triangles.size()}});
  }

  // Adds an accessor of the bytes from `begin` to the end.
  std::size_t AddAccessor(std::size_t begin, int target, Json accessor) {
    accessor["bufferView"] = views_.Add({{"buffer", 0},
                                         {"byteOffset", begin},
                                         {"byteLength", binary_.size() - begin},
                                         {"target", target}});
    return accessors_.Add(accessor);
  }

  const CancellationCheck& check_cancelled_;
  std::vector<std::string> nodes_;  // as JSON text
  std::vector<Parent> parents_;
  JsonList meshes_, materials_, accessors_, views_;
  std::map<const DrawnBody*, std::size_t> mesh_of_;
  std::map<std::pair<MaterialKind, bool>, std::size_t> material_index_;
  std::string robot_;  // the robot added last
  std::string binary_;
};

}  // namespace

absl::StatusOr<std::string> FormatGlb(const DrawnWorld& world,
                                      const CancellationCheck& check_cancelled) {
  Document document(world.name, check_cancelled);
  for (const DrawnItem& item : world.items) {
    if (absl::Status status = document.Add(item); !status.ok()) return status;
  }
  return document.Finish();
}

}  // namespace cwm::server
