#include "collision/mesh_files/glb_container.h"

// glTF 2.0, section 4.4 (the container).
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"

namespace cwm::collision {
namespace {

using Json = nlohmann::json;

// cited: glTF 2.0, section 4.4 (the container).
constexpr std::uint32_t kGlbVersion = 2;
constexpr std::uint32_t kGlbJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kGlbBinaryChunk = 0x004E4942;
constexpr std::size_t kGlbHeaderBytes = 12;
constexpr std::size_t kGlbChunkHeaderBytes = 8;

// measured: a mesh takes some hundred bytes of JSON, and a parsed document thirty times the size of
// its text. chosen: the parser cannot be interrupted, and takes some 20 ms for this much.
constexpr std::size_t kMaxJsonBytes = std::size_t{4} << 20;
constexpr std::size_t kMaxJsonValues = 250'000;
constexpr std::size_t kMaxJsonDepth = 64;  // glTF itself nests about ten deep

absl::Status InvalidGlb(const std::string& rule) { return absl::InvalidArgumentError(rule); }

std::uint32_t WordAt(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

// Checks a text before it is parsed into a document. (The parser's own callback takes quadratic
// time: at the end of each object it visits the whole enclosing array.)
class JsonCheck final : public nlohmann::json_sax<Json> {
 public:
  const char* fault() const { return fault_; }  // nullptr if there is none

  bool null() override { return Count(); }
  bool boolean(bool) override { return Count(); }
  bool number_integer(number_integer_t) override { return Count(); }
  bool number_unsigned(number_unsigned_t) override { return Count(); }
  bool number_float(number_float_t, const string_t&) override { return Count(); }
  bool string(string_t&) override { return Count(); }
  bool binary(binary_t&) override { return Count(); }
  bool start_object(std::size_t) override { return Open(); }
  bool start_array(std::size_t) override { return Open(); }
  bool key(string_t& name) override {
    return keys_.back().insert(name).second || Refuse("must not have a key twice in a JSON object");
  }
  bool end_object() override { return Close(); }
  bool end_array() override { return Close(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return Refuse("must have a JSON object");
  }

 private:
  bool Refuse(const char* fault) {
    fault_ = fault;
    return false;
  }
  bool Count() {
    return ++values_ <= kMaxJsonValues || Refuse("must have at most 250000 values in its JSON");
  }
  bool Open() {
    keys_.emplace_back();
    if (keys_.size() > kMaxJsonDepth) return Refuse("must not nest its JSON deeper than 64");
    return Count();
  }
  bool Close() {
    keys_.pop_back();
    return true;
  }

  std::vector<std::set<std::string>> keys_;  // of the open objects; an open array has an empty set
  std::size_t values_ = 0;
  const char* fault_ = nullptr;
};

}  // namespace

absl::StatusOr<GlbChunks> SplitGlb(std::string_view bytes) {
  if (bytes.size() < kGlbHeaderBytes + kGlbChunkHeaderBytes || !bytes.starts_with("glTF")) {
    return InvalidGlb("must begin with the header of a GLB file");
  }
  if (WordAt(bytes, 4) != kGlbVersion) {
    return InvalidGlb(absl::StrCat("is glTF ", WordAt(bytes, 4), ", must be glTF 2"));
  }
  const std::size_t json_bytes = WordAt(bytes, 12);
  if (WordAt(bytes, 8) != bytes.size() || WordAt(bytes, 16) != kGlbJsonChunk ||
      json_bytes > bytes.size() - kGlbHeaderBytes - kGlbChunkHeaderBytes) {
    return InvalidGlb("must be as long as its header says and begin with a JSON chunk inside it");
  }
  GlbChunks chunks{.json = bytes.substr(kGlbHeaderBytes + kGlbChunkHeaderBytes, json_bytes),
                   .binary = {}};
  const std::string_view rest = bytes.substr(kGlbHeaderBytes + kGlbChunkHeaderBytes + json_bytes);
  if (rest.empty()) return chunks;
  if (rest.size() < kGlbChunkHeaderBytes || WordAt(rest, 4) != kGlbBinaryChunk ||
      WordAt(rest, 0) > rest.size() - kGlbChunkHeaderBytes) {
    return InvalidGlb("must hold a binary chunk after the JSON chunk, inside the file");
  }
  chunks.binary = rest.substr(kGlbChunkHeaderBytes, WordAt(rest, 0));
  return chunks;
}

absl::StatusOr<Json> ParseGlbJson(std::string_view text) {
  if (text.size() > kMaxJsonBytes) return InvalidGlb("must have at most 4 MiB of JSON");
  JsonCheck check;
  Json::sax_parse(text.begin(), text.end(), &check);
  if (check.fault() != nullptr) return InvalidGlb(check.fault());
  Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return InvalidGlb("must have a JSON object");
  return json;
}

}  // namespace cwm::collision
