#include "collision/mesh_files/glb_file.h"

// glTF 2.0, sections 3.5 (scenes and nodes), 3.6 (buffers, views, accessors) and 3.7 (meshes).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "collision/mesh_files/glb_container.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/mesh_files/scene_graph.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

using Json = nlohmann::json;
using Affine = Eigen::Affine3d;

constexpr std::size_t kNone = SIZE_MAX;
constexpr std::size_t kTriangles = 4;  // modes of a primitive
constexpr std::size_t kTriangleStrip = 5;
constexpr std::size_t kTriangleFan = 6;
// Extensions that change the look of surfaces, not their positions.
constexpr std::array<std::string_view, 5> kIgnoredExtensions = {
    "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_"};

// The bytes of a primitive's positions or indices. Element i begins at i * stride.
struct Elements {
  const char* begin = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  std::size_t bytes = 0;  // of one element
};

struct Primitive {
  std::size_t mode = kTriangles;
  Elements positions;
  std::optional<Elements> indices;
  std::size_t triangles = 0;
};

// Reads the geometry of a document. The first fault is kept; everything read after it is empty.
class GlbReader {
 public:
  GlbReader(const Json& json, std::string_view binary, const MeshFileLimits& limits)
      : json_(json), binary_(binary), limits_(limits), mesh_(limits.max_triangles) {}

  absl::StatusOr<TriangleMesh> Read() && {
    CheckExtensions();
    CheckBuffer();
    const Json& nodes = ListOf(json_, "nodes");
    const std::vector<std::size_t> roots = ReadTree(nodes);
    if (!status_.ok()) return status_;
    // All triangles are counted before any is added.
    below_.assign(nodes.size(), std::nullopt);
    std::size_t triangles = 0;
    for (const std::size_t root : roots) triangles = Sum(triangles, TrianglesBelow(root));
    if (!status_.ok()) return status_;
    if (absl::Status room = mesh_.CheckCapacity(triangles); !room.ok()) return room;
    for (const std::size_t root : roots) AddNode(root, Affine::Identity());
    if (!status_.ok()) return status_;
    return std::move(mesh_).Finish();
  }

 private:
  void Fail(const std::string& rule) { status_.Update(absl::InvalidArgumentError(rule)); }

  // The list under `key`; empty if it is absent.
  const Json& ListOf(const Json& object, const char* key) {
    static const Json kEmpty = Json::array();
    if (!object.is_object()) Fail(absl::StrCat("what may hold ", key, " must be a JSON object"));
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end()) return kEmpty;
    if (!found->is_array()) Fail(absl::StrCat(key, " must be a list"));
    return found->is_array() ? *found : kEmpty;
  }

  // A count, offset or index; kNone if it is wrong, `otherwise` if it is absent. At most 2^32 - 1,
  // so that a sum of three cannot overflow.
  static std::size_t CountAt(const Json& object, const char* key, std::size_t otherwise = kNone) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end()) return otherwise;
    if (!found->is_number_unsigned() || found->get<std::uint64_t>() > UINT32_MAX) return kNone;
    return found->get<std::size_t>();
  }

  // Exactly `count` finite numbers. Empty if the key is absent or, with a fault, if its value is
  // wrong.
  std::vector<double> NumbersAt(const Json& object, const char* key, std::size_t count) {
    const Json& list = ListOf(object, key);
    std::vector<double> numbers;
    for (const Json& number : list) {
      if (!number.is_number() || numbers.size() == count) break;
      numbers.push_back(number.get<double>());
    }
    const bool is_right = numbers.size() == count && list.size() == count &&
                          std::ranges::all_of(numbers, [](double n) { return std::isfinite(n); });
    if (!is_right && object.contains(key)) {
      Fail(absl::StrCat("the ", key, " of a node must be ", count, " finite numbers"));
    }
    return is_right ? numbers : std::vector<double>();
  }

  void CheckExtensions() {
    const auto is_harmless = [](const std::string& name) {
      return std::ranges::any_of(kIgnoredExtensions,
                                 [&](std::string_view known) { return name.starts_with(known); });
    };
    for (const Json& name : ListOf(json_, "extensionsRequired")) {
      if (!name.is_string() || !is_harmless(name.get<std::string>())) {
        return Fail(absl::StrCat("requires the extension ",
                                 Quoted(name.dump(-1, ' ', true, Json::error_handler_t::replace)),
                                 ", which is not understood"));
      }
    }
    for (const Json& name : ListOf(json_, "extensionsUsed")) {
      if (name == "EXT_mesh_gpu_instancing") {
        return Fail("uses the extension EXT_mesh_gpu_instancing, which is not understood");
      }
    }
  }

  void CheckBuffer() {
    const Json& buffers = ListOf(json_, "buffers");
    if (buffers.size() > 1) Fail("must have one buffer, its own binary chunk");
    for (const Json& buffer : buffers) {
      const std::size_t length = CountAt(buffer, "byteLength");
      if (length > binary_.size() || buffer.contains("uri")) {
        return Fail("its buffer must be its own binary chunk");
      }
      binary_ = binary_.substr(0, length);
    }
    if (buffers.empty()) binary_ = {};
  }

  // Checks all nodes and returns the roots of the scene to be shown.
  std::vector<std::size_t> ReadTree(const Json& nodes) {
    if (nodes.size() > kMaxSceneNodes) Fail("nodes must not unfold to more than 100000");
    std::vector<std::vector<int>> children;
    for (std::size_t i = 0; status_.ok() && i < nodes.size(); ++i) {
      const std::vector<std::size_t> below = NodesAt(nodes[i], "children", nodes.size());
      children.emplace_back(below.begin(), below.end());
    }
    const Json& scenes = ListOf(json_, "scenes");
    const std::size_t scene = CountAt(json_, "scene", 0);
    if (scene >= scenes.size()) Fail("must have the scene that is to be shown");
    if (!status_.ok()) return {};
    std::vector<std::size_t> roots = NodesAt(scenes[scene], "nodes", nodes.size());
    children.emplace_back(roots.begin(), roots.end());
    if (status_.ok()) status_.Update(CheckSceneGraph(children));
    return roots;
  }

  std::vector<std::size_t> NodesAt(const Json& object, const char* key, std::size_t count) {
    std::vector<std::size_t> indices;
    for (const Json& index : ListOf(object, key)) {
      if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= count) {
        Fail(absl::StrCat("the ", key, " of a node or scene must be nodes"));
        return {};
      }
      indices.push_back(index.get<std::size_t>());
    }
    return indices;
  }

  // The sum, capped just above the limit of triangles so that it cannot overflow.
  std::size_t Sum(std::size_t a, std::size_t b) const {
    return std::min(a + b, limits_.max_triangles + 1);
  }

  // The number of triangles of a node and all nodes below it, each counted as often as it is used.
  // The recursion is as deep as the nodes, which CheckSceneGraph bounds; each node is computed
  // once.
  std::size_t TrianglesBelow(std::size_t index) {
    if (below_[index].has_value()) return *below_[index];
    const Json& node = json_["nodes"][index];
    std::size_t triangles = 0;
    for (const Primitive& primitive : PrimitivesOf(node)) {
      triangles = Sum(triangles, primitive.triangles);
    }
    for (const Json& child : ListOf(node, "children")) {
      triangles = Sum(triangles, TrianglesBelow(child.get<std::size_t>()));
    }
    below_[index] = triangles;
    return triangles;
  }

  // The primitives of the node's mesh, read when a node first uses the mesh.
  const std::vector<Primitive>& PrimitivesOf(const Json& node) {
    static const std::vector<Primitive> kEmpty;
    if (!node.contains("mesh") || !status_.ok()) return kEmpty;
    const Json& meshes = ListOf(json_, "meshes");
    const std::size_t index = CountAt(node, "mesh");
    if (index >= meshes.size()) Fail("nodes must use meshes that there are");
    if (node.contains("skin")) Fail("skins are not understood");
    if (!status_.ok()) return kEmpty;
    const auto [known, is_new] = primitives_.try_emplace(index);
    if (!is_new) return known->second;
    for (const Json& primitive : ListOf(meshes[index], "primitives")) {
      known->second.push_back(ReadPrimitive(primitive));
      if (!status_.ok()) break;
    }
    return known->second;
  }

  Primitive ReadPrimitive(const Json& json) {
    Primitive read;
    read.mode = CountAt(json, "mode", kTriangles);
    if (read.mode < kTriangles || read.mode > kTriangleFan || json.contains("targets")) {
      Fail("every primitive must be triangles, a strip or a fan, without morph targets");
      return read;
    }
    const auto attributes = json.is_object() ? json.find("attributes") : json.end();
    if (!json.is_object() || attributes == json.end() || !attributes->is_object()) {
      Fail("every primitive must have attributes");
      return read;
    }
    read.positions = ReadElements(CountAt(*attributes, "POSITION"), "VEC3", {{5126, 12}},
                                  "positions must be an accessor of three floats");
    std::size_t corners = read.positions.count;
    if (json.contains("indices")) {
      read.indices =
          ReadElements(CountAt(json, "indices"), "SCALAR", {{5121, 1}, {5123, 2}, {5125, 4}},
                       "indices must be an accessor of unsigned integers");
      corners = read.indices->count;
    }
    if (!status_.ok()) return read;
    if (corners < 3 || (read.mode == kTriangles && corners % 3 != 0)) {
      Fail(absl::StrCat("a primitive has ", corners, " corners, must have ",
                        read.mode == kTriangles ? "a multiple of 3" : "at least 3"));
      return read;
    }
    read.triangles = read.mode == kTriangles ? corners / 3 : corners - 2;
    return read;
  }

  // The elements of an accessor. `sizes` maps each allowed component type to the number of bytes of
  // an element.
  Elements ReadElements(std::size_t index, std::string_view type,
                        const std::map<std::size_t, std::size_t>& sizes, const char* rule) {
    const Json& accessors = ListOf(json_, "accessors");
    const Json& views = ListOf(json_, "bufferViews");
    if (index >= accessors.size()) Fail(rule);
    if (!status_.ok()) return {};
    const Json& accessor = accessors[index];
    const auto size = sizes.find(CountAt(accessor, "componentType"));
    if (size == sizes.end() || accessor.value("type", Json()) != type) Fail(rule);
    const std::size_t view_index = CountAt(accessor, "bufferView");
    if (view_index >= views.size() || accessor.contains("sparse")) {
      Fail("every accessor must lie inside its bufferView, and not be sparse");
    }
    if (!status_.ok()) return {};
    const Json& view = views[view_index];
    const std::size_t begin = CountAt(view, "byteOffset", 0), length = CountAt(view, "byteLength");
    if (CountAt(view, "buffer") != 0 || begin > binary_.size() || length > binary_.size() - begin) {
      Fail("every bufferView must lie inside the binary chunk");
      return {};
    }
    const std::size_t offset = CountAt(accessor, "byteOffset", 0);
    const std::size_t count = CountAt(accessor, "count");
    const std::size_t stride = CountAt(view, "byteStride", size->second);
    const bool is_stride = view.contains("byteStride") ? stride >= 4 && stride <= 252 : true;
    if (offset == kNone || count == kNone || count == 0 || !is_stride || stride < size->second ||
        offset + (count - 1) * stride + size->second > length) {
      Fail("every accessor must lie inside its bufferView, and not be sparse");
      return {};
    }
    return {binary_.data() + begin + offset, count, stride, size->second};
  }

  void AddNode(std::size_t index, const Affine& X_FP) {
    if (!status_.ok() || *below_[index] == 0) return;
    const Json& node = json_["nodes"][index];
    const Affine X_FN = X_FP * TransformOf(node);
    if (!status_.ok()) return;
    for (const Primitive& primitive : PrimitivesOf(node)) AddPrimitive(primitive, X_FN);
    for (const Json& child : ListOf(node, "children")) AddNode(child.get<std::size_t>(), X_FN);
  }

  Affine TransformOf(const Json& node) {
    Affine X_PN = Affine::Identity();
    if (const std::vector<double> m = NumbersAt(node, "matrix", 16); !m.empty()) {  // column-major
      X_PN.matrix() = Eigen::Map<const Eigen::Matrix4d>(m.data());
      if (!X_PN.matrix().row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1))) {
        Fail("the matrix of a node must have the last row 0 0 0 1");
      }
      return X_PN;
    }
    const std::vector<double> t = NumbersAt(node, "translation", 3);
    const std::vector<double> r = NumbersAt(node, "rotation", 4);
    const std::vector<double> s = NumbersAt(node, "scale", 3);
    if (!t.empty()) X_PN.translate(Vector3(t.data()));
    if (!r.empty()) {
      const Quaternion q(r[3], r[0], r[1], r[2]);
      if (!(std::abs(q.norm() - 1) < kUnitTolerance))
        Fail("the rotation of a node must be a unit quaternion");
      X_PN.rotate(q.normalized());
    }
    if (!s.empty()) X_PN.scale(Vector3(s.data()));
    return X_PN;
  }

  void AddPrimitive(const Primitive& primitive, const Affine& X_FN) {
    const bool is_mirrored = X_FN.linear().determinant() < 0;
    for (std::size_t i = 0; status_.ok() && i < primitive.triangles; ++i) {
      std::array<std::size_t, 3> at = {3 * i, 3 * i + 1, 3 * i + 2};
      if (primitive.mode == kTriangleStrip) at = {i, i + 1 + i % 2, i + 2 - i % 2};
      if (primitive.mode == kTriangleFan) at = {0, i + 1, i + 2};
      std::array<Vector3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t vertex = VertexAt(primitive, at[k]);
        if (vertex >= primitive.positions.count)
          return Fail("faces must use vertices that there are");
        float p[3];
        std::memcpy(p, primitive.positions.begin + vertex * primitive.positions.stride, sizeof(p));
        corners[k] = X_FN * Vector3(p[0], p[1], p[2]);
      }
      if (is_mirrored) std::swap(corners[1], corners[2]);
      status_.Update(mesh_.Add(corners));
    }
  }

  static std::size_t VertexAt(const Primitive& primitive, std::size_t corner) {
    if (!primitive.indices.has_value()) return corner;
    std::uint32_t vertex = 0;  // the machine and the file are both little-endian
    std::memcpy(&vertex, primitive.indices->begin + corner * primitive.indices->stride,
                primitive.indices->bytes);
    return vertex;
  }

  // chosen: exporters write quaternions in single precision, some with few digits.
  static constexpr double kUnitTolerance = 1e-2;

  const Json& json_;
  std::string_view binary_;
  const MeshFileLimits& limits_;
  absl::Status status_;
  MeshBuilder mesh_;
  std::map<std::size_t, std::vector<Primitive>> primitives_;  // by index of the mesh
  std::vector<std::optional<std::size_t>> below_;             // number of triangles, by node
};

}  // namespace

absl::StatusOr<TriangleMesh> ReadGlb(std::string_view bytes, const MeshFileLimits& limits) {
  const absl::StatusOr<GlbChunks> chunks = SplitGlb(bytes);
  if (!chunks.ok()) return chunks.status();
  const absl::StatusOr<Json> json = ParseGlbJson(chunks->json);
  if (!json.ok()) return json.status();
  return GlbReader(*json, chunks->binary, limits).Read();
}

}  // namespace cwm::collision
