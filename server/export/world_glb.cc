// Binary glTF 2.0; declared in drawn_world.h. Sections are those of its specification.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/export/drawn_world.h"
#include "server/export/file_bytes.h"

namespace cwm::server {
namespace {

using Json = nlohmann::ordered_json;

// Sections 4.4, 5.1 and 5.11.
constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

// Colours of files are sRGB, factors of materials linear (section 3.9.2).
double Linear(std::uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

Json MaterialOf(Look look, bool is_closed) {
  const auto [red, green, blue, opacity] = ColourOf(look);
  Json material = {
      {"name", std::string(NameOf(look)) + (is_closed ? "" : ", open")},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {Linear(red), Linear(green), Linear(blue), opacity / 255.0}},
        {"metallicFactor", 0},
        {"roughnessFactor", 0.8}}}};
  if (opacity < 255) material["alphaMode"] = "BLEND";
  if (!is_closed) material["doubleSided"] = true;
  return material;
}

// The JSON and the bytes that it refers to.
class Document {
 public:
  explicit Document(const std::string& name) {
    // -90 degrees about x: the world's Z becomes glTF's Y.
    nodes_.push_back({{"name", name}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}});
    children_.emplace_back();
  }

  // Below the root, or below the robot that was added last.
  void Add(const DrawnThing& thing) {
    if (!thing.robot.empty() && robot_ != thing.robot) AddRobot(thing.robot);
    Json node = {{"name", thing.name}, {"mesh", MeshOf(thing.body.get())}};
    Place(thing.X_WB, node);
    for (const auto& [name, value] : thing.facts) node["extras"][name] = value;
    AddNode(std::move(node), thing.robot.empty() ? 0 : robot_node_);
  }

  std::string Finish() {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (!children_[i].empty()) nodes_[i]["children"] = std::move(children_[i]);
    }
    Json document = {{"asset", {{"version", "2.0"}, {"generator", "cwm"}}},
                     {"scene", 0},
                     {"scenes", Json::array({{{"nodes", Json::array({0})}}})},
                     {"nodes", std::move(nodes_)}};
    if (!meshes_.empty()) {  // no array may be empty
      document["meshes"] = std::move(meshes_);
      document["materials"] = std::move(materials_);
      document["accessors"] = std::move(accessors_);
      document["bufferViews"] = std::move(views_);
      document["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
    }
    std::string chunks;
    AppendChunk(kJsonChunk, ' ', document.dump(), chunks);
    if (!binary_.empty()) AppendChunk(kBinaryChunk, '\0', std::move(binary_), chunks);
    std::string file;
    AppendBytes(kMagic, file);
    AppendBytes(kVersion, file);
    AppendBytes(static_cast<std::uint32_t>(3 * sizeof(std::uint32_t) + chunks.size()), file);
    return file + chunks;
  }

 private:
  // Chunks begin and end at multiples of four.
  static void AppendChunk(std::uint32_t type, char padding, std::string content,
                          std::string& chunks) {
    content.append((4 - content.size() % 4) % 4, padding);
    AppendBytes(static_cast<std::uint32_t>(content.size()), chunks);
    AppendBytes(type, chunks);
    chunks += content;
  }

  static void Place(const Pose& X_WB, Json& node) {
    const Quaternion q = Quaternion(X_WB.linear()).normalized();
    const Vector3& p = X_WB.translation();
    node["translation"] = {p.x(), p.y(), p.z()};
    node["rotation"] = {q.x(), q.y(), q.z(), q.w()};
  }

  std::size_t AddNode(Json node, std::size_t parent) {
    nodes_.push_back(std::move(node));
    children_.emplace_back();
    children_[parent].push_back(nodes_.size() - 1);
    return nodes_.size() - 1;
  }

  void AddRobot(const std::string& name) {
    robot_ = name;
    robot_node_ = AddNode({{"name", name}}, 0);
  }

  std::size_t MeshOf(const DrawnBody* body) {
    const auto [at, is_new] = mesh_of_.try_emplace(body, meshes_.size());
    if (!is_new) return at->second;
    Json primitives = Json::array();
    for (const DrawnPiece& piece : *body) {
      primitives.push_back({{"attributes", {{"POSITION", Positions(piece.mesh)}}},
                            {"indices", Indices(piece.mesh)},
                            {"material", MaterialIndex(piece.look, piece.is_closed)}});
    }
    meshes_.push_back({{"primitives", std::move(primitives)}});
    return at->second;
  }

  std::size_t MaterialIndex(Look look, bool is_closed) {
    const auto [at, is_new] = material_of_.try_emplace({look, is_closed}, materials_.size());
    if (is_new) materials_.push_back(MaterialOf(look, is_closed));
    return at->second;
  }

  std::size_t Positions(const TriangleMesh& mesh) {
    const std::size_t begin = binary_.size();
    std::array<float, 3> min{}, max{};
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      for (std::size_t i = 0; i < 3; ++i) {
        const auto value = static_cast<float>(mesh.vertices[v][static_cast<int>(i)]);
        min[i] = v == 0 ? value : std::min(min[i], value);
        max[i] = v == 0 ? value : std::max(max[i], value);
        AppendBytes(value, binary_);
      }
    }
    return AddAccessor(begin, kArrayBuffer,
                       {{"componentType", kFloat},
                        {"type", "VEC3"},
                        {"count", mesh.vertices.size()},
                        {"min", min},
                        {"max", max}});
  }

  std::size_t Indices(const TriangleMesh& mesh) {
    const std::size_t begin = binary_.size();
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle) AppendBytes(vertex, binary_);
    }
    return AddAccessor(begin, kElementArrayBuffer,
                       {{"componentType", kUnsignedInt},
                        {"type", "SCALAR"},
                        {"count", 3 * mesh.triangles.size()}});
  }

  // Of the bytes from `begin` to the end.
  std::size_t AddAccessor(std::size_t begin, int target, Json accessor) {
    views_.push_back({{"buffer", 0},
                      {"byteOffset", begin},
                      {"byteLength", binary_.size() - begin},
                      {"target", target}});
    accessor["bufferView"] = views_.size() - 1;
    accessors_.push_back(std::move(accessor));
    return accessors_.size() - 1;
  }

  std::vector<Json> nodes_;
  std::vector<std::vector<std::size_t>> children_;  // by node
  Json meshes_ = Json::array(), materials_ = Json::array(), accessors_ = Json::array(),
       views_ = Json::array();
  std::map<const DrawnBody*, std::size_t> mesh_of_;
  std::map<std::pair<Look, bool>, std::size_t> material_of_;
  std::string robot_;  // that was added last
  std::size_t robot_node_ = 0;
  std::string binary_;
};

}  // namespace

absl::StatusOr<std::string> FormatGlb(const DrawnWorld& world, const GoOn& go_on) {
  Document document(world.name);
  for (const DrawnThing& thing : world.things) {
    if (absl::Status status = go_on(); !status.ok()) return status;
    document.Add(thing);
  }
  return document.Finish();
}

}  // namespace cwm::server
