#include "collision/mesh_files/glb_guard.h"

// glTF 2.0, sections 3.5 (nodes), 3.6 (buffers, views, accessors) and 4.4
// (the container).
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "collision/mesh_files/scene_graph.h"

namespace cwm::collision {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kHeader = 12;
constexpr std::size_t kChunkHeader = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126;
constexpr std::size_t kTriangles = 4;
constexpr std::size_t kTriangleFan = 6;
// A description of meshes takes some hundred bytes a mesh; parsed it takes thirty times its size.
constexpr std::size_t kMostJsonBytes = std::size_t{16} << 20;
constexpr int kDeepestJson = 64;  // glTF itself nests about ten deep

absl::Status Fault(const std::string& rule) { return absl::InvalidArgumentError(rule); }

std::uint32_t WordAt(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

struct Chunks {
  std::string_view json;
  std::string_view binary;
};

absl::StatusOr<Chunks> Split(std::string_view bytes) {
  if (bytes.size() < kHeader + kChunkHeader || !bytes.starts_with("glTF")) {
    return Fault("must begin with the header of a GLB file");
  }
  if (WordAt(bytes, 4) != 2) {
    return Fault(absl::StrCat("is glTF ", WordAt(bytes, 4), ", must be glTF 2"));
  }
  const std::size_t json_bytes = WordAt(bytes, 12);
  if (WordAt(bytes, 8) != bytes.size() || WordAt(bytes, 16) != kJsonChunk ||
      json_bytes > bytes.size() - kHeader - kChunkHeader) {
    return Fault("must be as long as its header says and begin with a JSON chunk inside it");
  }
  Chunks chunks{.json = bytes.substr(kHeader + kChunkHeader, json_bytes), .binary = {}};
  const std::string_view rest = bytes.substr(kHeader + kChunkHeader + json_bytes);
  if (rest.empty()) return chunks;
  if (rest.size() < kChunkHeader || WordAt(rest, 4) != kBinaryChunk ||
      WordAt(rest, 0) > rest.size() - kChunkHeader) {
    return Fault("must hold a binary chunk after the JSON chunk, inside the file");
  }
  chunks.binary = rest.substr(kChunkHeader, WordAt(rest, 0));
  return chunks;
}

// Looks on while JSON is parsed, for what two parsers may understand differently.
class Watch {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    too_deep_ = too_deep_ || depth > kDeepestJson;
    if (event == Json::parse_event_t::object_start) keys_.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_.pop_back();
    if (event == Json::parse_event_t::key) {
      has_twin_ = has_twin_ || !keys_.back().insert(parsed.get<std::string>()).second;
    }
    return true;
  }
  bool too_deep() const { return too_deep_; }
  bool has_twin() const { return has_twin_; }

 private:
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
  bool too_deep_ = false;
  bool has_twin_ = false;
};

absl::StatusOr<Json> Parse(std::string_view text) {
  if (text.size() > kMostJsonBytes) return Fault("must have at most 16 MiB of JSON");
  Watch watch;
  Json json = Json::parse(text.begin(), text.end(), std::ref(watch), /*allow_exceptions=*/false);
  if (json.is_discarded() || !json.is_object()) return Fault("must have a JSON object");
  if (watch.too_deep()) return Fault("must not nest its JSON deeper than 64");
  if (watch.has_twin()) return Fault("must not have a key twice in a JSON object");
  return json;
}

const Json& ListOf(const Json& object, const char* key) {
  static const Json kNone = Json::array();
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : kNone;
}

// A count, offset or index; nothing where it is not one.
std::optional<std::size_t> CountAt(const Json& object, const char* key,
                                   std::optional<std::size_t> otherwise = std::nullopt) {
  if (!object.is_object()) return std::nullopt;
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  // Sums of three such cannot overflow.
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
  return found->get<std::size_t>();
}

std::string WordOf(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

class GlbChecker {
 public:
  GlbChecker(const Json& json, std::string_view binary, const MeshFileLimits& limits)
      : json_(json), binary_(binary), limits_(limits) {}

  absl::Status Check() {
    if (absl::Status status = CheckNodes(); !status.ok()) return status;
    if (absl::Status status = CheckBuffers(); !status.ok()) return status;
    for (const Json& view : ListOf(json_, "bufferViews")) {
      if (!IsViewInside(view)) return Fault("every bufferView must lie inside the binary chunk");
    }
    for (const Json& accessor : ListOf(json_, "accessors")) {
      if (!IsAccessorInside(accessor)) {
        return Fault("every accessor must lie inside its bufferView, and not be sparse");
      }
    }
    return CheckMeshes();
  }

 private:
  absl::Status CheckNodes() const {
    const Json& nodes = ListOf(json_, "nodes");
    std::vector<std::vector<int>> children(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!AppendNodes(ListOf(nodes[i], "children"), nodes.size(), children[i])) {
        return Fault("the children of a node must be nodes");
      }
    }
    for (const Json& scene : ListOf(json_, "scenes")) {
      if (!AppendNodes(ListOf(scene, "nodes"), nodes.size(), children.emplace_back())) {
        return Fault("the nodes of a scene must be nodes");
      }
    }
    return CheckSceneGraph(children);
  }

  static bool AppendNodes(const Json& list, std::size_t count, std::vector<int>& indices) {
    for (const Json& index : list) {
      if (!index.is_number_unsigned() || index.get<std::uint64_t>() >= count) return false;
      indices.push_back(index.get<int>());
    }
    return true;
  }

  absl::Status CheckBuffers() const {
    const Json& buffers = ListOf(json_, "buffers");
    if (buffers.size() > 1) return Fault("must have one buffer, its own binary chunk");
    for (const Json& buffer : buffers) {
      const auto length = CountAt(buffer, "byteLength");
      if (!length.has_value() || *length > binary_.size() || buffer.contains("uri")) {
        return Fault("its buffer must be its own binary chunk");
      }
    }
    return absl::OkStatus();
  }

  bool IsViewInside(const Json& view) const {
    const Json& buffers = ListOf(json_, "buffers");
    const auto buffer = CountAt(view, "buffer");
    const auto offset = CountAt(view, "byteOffset", 0);
    const auto length = CountAt(view, "byteLength");
    const auto stride = CountAt(view, "byteStride", 4);
    return buffer == 0 && buffers.size() == 1 && offset && length && stride && *stride >= 4 &&
           *stride <= 252 && *offset + *length <= *CountAt(buffers[0], "byteLength");
  }

  bool IsAccessorInside(const Json& accessor) const {
    const Json& views = ListOf(json_, "bufferViews");
    const auto view = CountAt(accessor, "bufferView");
    const auto offset = CountAt(accessor, "byteOffset", 0);
    const auto count = CountAt(accessor, "count");
    const auto size = ElementSize(accessor);
    if (!view || *view >= views.size() || !offset || !count || *count == 0 || !size ||
        accessor.contains("sparse")) {
      return false;
    }
    const std::size_t stride = *CountAt(views[*view], "byteStride", *size);
    return stride >= *size &&
           *offset + (*count - 1) * stride + *size <= *CountAt(views[*view], "byteLength");
  }

  static std::optional<std::size_t> ElementSize(const Json& accessor) {
    static const std::map<std::string, std::size_t> kComponents = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
        {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    static const std::map<std::size_t, std::size_t> kBytes = {{5120, 1}, {5121, 1}, {5122, 2},
                                                              {5123, 2}, {5125, 4}, {5126, 4}};
    const auto type = CountAt(accessor, "componentType");
    if (!type) return std::nullopt;
    const auto components = kComponents.find(WordOf(accessor, "type"));
    const auto bytes = kBytes.find(*type);
    if (components == kComponents.end() || bytes == kBytes.end()) return std::nullopt;
    return components->second * bytes->second;
  }

  absl::Status CheckMeshes() const {
    std::size_t elements = 0;
    for (const Json& mesh : ListOf(json_, "meshes")) {
      for (const Json& primitive : ListOf(mesh, "primitives")) {
        const std::optional<std::size_t> more = ElementsOf(primitive);
        if (!more) {
          return Fault(
              "every primitive must be triangles with accessors, positions of three floats, and no "
              "morph targets");
        }
        elements += *more;
        // Three indices and half a vertex with its normal and colours a triangle.
        if (elements > 8 * limits_.max_triangles) {
          return absl::ResourceExhaustedError(absl::StrCat(
              "must have at most ", limits_.max_triangles, " triangles in all its primitives"));
        }
        if (!UsesItsVertices(primitive)) return Fault("faces must use vertices that there are");
      }
    }
    return absl::OkStatus();
  }

  // How much a primitive makes the reader copy.
  std::optional<std::size_t> ElementsOf(const Json& primitive) const {
    if (!primitive.is_object() || primitive.contains("targets")) return std::nullopt;
    const auto mode = CountAt(primitive, "mode", kTriangles);
    if (!mode || *mode < kTriangles || *mode > kTriangleFan) return std::nullopt;
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) return std::nullopt;
    const Json& accessors = ListOf(json_, "accessors");
    const auto positions = CountAt(*attributes, "POSITION");
    if (!positions || *positions >= accessors.size() ||
        WordOf(accessors[*positions], "type") != "VEC3" ||
        CountAt(accessors[*positions], "componentType") != kFloat) {
      return std::nullopt;
    }
    std::size_t elements = 0;
    for (const auto& attribute : attributes->items()) {
      const auto index = CountAt(*attributes, attribute.key().c_str());
      if (!index || *index >= accessors.size()) return std::nullopt;
      elements += *CountAt(accessors[*index], "count");
    }
    if (!primitive.contains("indices")) return elements;
    const auto indices = CountAt(primitive, "indices");
    if (!indices || *indices >= accessors.size() ||
        WordOf(accessors[*indices], "type") != "SCALAR" ||
        CountAt(accessors[*indices], "componentType") == kFloat) {
      return std::nullopt;
    }
    return elements + *CountAt(accessors[*indices], "count");
  }

  // After ElementsOf; assimp passes over triangles that do not.
  bool UsesItsVertices(const Json& primitive) const {
    if (!primitive.contains("indices")) return true;
    const Json& accessors = ListOf(json_, "accessors");
    const Json& indices = accessors[*CountAt(primitive, "indices")];
    const Json& positions = accessors[*CountAt(primitive["attributes"], "POSITION")];
    const Json& view = ListOf(json_, "bufferViews")[*CountAt(indices, "bufferView")];
    const std::size_t size = *ElementSize(indices), stride = *CountAt(view, "byteStride", size);
    std::size_t at = *CountAt(view, "byteOffset", 0) + *CountAt(indices, "byteOffset", 0);
    const std::size_t count = *CountAt(indices, "count"), vertices = *CountAt(positions, "count");
    for (std::size_t i = 0; i < count; ++i, at += stride) {
      std::uint32_t index = 0;
      std::memcpy(&index, binary_.data() + at, size);  // both are little-endian
      if (index >= vertices) return false;
    }
    return true;
  }

  const Json& json_;
  std::string_view binary_;
  const MeshFileLimits& limits_;
};

}  // namespace

absl::Status GuardGlb(std::string_view bytes, const MeshFileLimits& limits) {
  const absl::StatusOr<Chunks> chunks = Split(bytes);
  if (!chunks.ok()) return chunks.status();
  const absl::StatusOr<Json> json = Parse(chunks->json);
  if (!json.ok()) return json.status();
  return GlbChecker(*json, chunks->binary, limits).Check();
}

}  // namespace cwm::collision
