#include "collision/mesh_files/glb_container.h"

// glTF 2.0, section 4.4 (the container).
#include <cstdint>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"

namespace cwm::collision {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
// A description of meshes takes some hundred bytes a mesh; parsed it takes thirty times its size.
constexpr std::size_t kMaxJsonBytes = std::size_t{16} << 20;
constexpr int kMaxJsonDepth = 64;  // glTF itself nests about ten deep

absl::Status Fault(const std::string& rule) { return absl::InvalidArgumentError(rule); }

std::uint32_t WordAt(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

// Sees each event of the parser. What it refuses is not kept.
class JsonFilter {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    too_deep_ = too_deep_ || depth > kMaxJsonDepth;
    if (event == Json::parse_event_t::object_start) keys_.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_.pop_back();
    if (event == Json::parse_event_t::key) {
      has_twin_ = has_twin_ || !keys_.back().insert(parsed.get<std::string>()).second;
    }
    return !too_deep_;
  }
  bool too_deep() const { return too_deep_; }
  bool has_twin() const { return has_twin_; }

 private:
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
  bool too_deep_ = false;
  bool has_twin_ = false;
};

}  // namespace

absl::StatusOr<GlbChunks> SplitGlb(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes + kChunkHeaderBytes || !bytes.starts_with("glTF")) {
    return Fault("must begin with the header of a GLB file");
  }
  if (WordAt(bytes, 4) != 2) {
    return Fault(absl::StrCat("is glTF ", WordAt(bytes, 4), ", must be glTF 2"));
  }
  const std::size_t json_bytes = WordAt(bytes, 12);
  if (WordAt(bytes, 8) != bytes.size() || WordAt(bytes, 16) != kJsonChunk ||
      json_bytes > bytes.size() - kHeaderBytes - kChunkHeaderBytes) {
    return Fault("must be as long as its header says and begin with a JSON chunk inside it");
  }
  GlbChunks chunks{.json = bytes.substr(kHeaderBytes + kChunkHeaderBytes, json_bytes),
                   .binary = {}};
  const std::string_view rest = bytes.substr(kHeaderBytes + kChunkHeaderBytes + json_bytes);
  if (rest.empty()) return chunks;
  if (rest.size() < kChunkHeaderBytes || WordAt(rest, 4) != kBinaryChunk ||
      WordAt(rest, 0) > rest.size() - kChunkHeaderBytes) {
    return Fault("must hold a binary chunk after the JSON chunk, inside the file");
  }
  chunks.binary = rest.substr(kChunkHeaderBytes, WordAt(rest, 0));
  return chunks;
}

absl::StatusOr<Json> ParseGlbJson(std::string_view text) {
  if (text.size() > kMaxJsonBytes) return Fault("must have at most 16 MiB of JSON");
  JsonFilter filter;
  Json json = Json::parse(text.begin(), text.end(), std::ref(filter), /*allow_exceptions=*/false);
  if (filter.too_deep()) return Fault("must not nest its JSON deeper than 64");
  if (json.is_discarded() || !json.is_object()) return Fault("must have a JSON object");
  if (filter.has_twin()) return Fault("must not have a key twice in a JSON object");
  return json;
}

}  // namespace cwm::collision
