#include "clients/formats/ply_header.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"

namespace cwm::formats {
namespace {

using Words = std::vector<std::string_view>;

std::optional<Scalar> ScalarOf(std::string_view name) {
  static const std::map<std::string_view, Scalar> kScalars = {
      {"char", Scalar::kI8},    {"int8", Scalar::kI8},     {"uchar", Scalar::kU8},
      {"uint8", Scalar::kU8},   {"short", Scalar::kI16},   {"int16", Scalar::kI16},
      {"ushort", Scalar::kU16}, {"uint16", Scalar::kU16},  {"int", Scalar::kI32},
      {"int32", Scalar::kI32},  {"uint", Scalar::kU32},    {"uint32", Scalar::kU32},
      {"float", Scalar::kF32},  {"float32", Scalar::kF32}, {"double", Scalar::kF64},
      {"float64", Scalar::kF64}};
  const auto found = kScalars.find(name);
  if (found == kScalars.end()) return std::nullopt;
  return found->second;
}

// chosen: each name is searched among all others; scanners write about ten.
constexpr std::size_t kMaxElements = 256;
constexpr std::size_t kMaxProperties = 1024;  // per element

bool IsInteger(Scalar type) { return type != Scalar::kF32 && type != Scalar::kF64; }

class HeaderParser {
 public:
  explicit HeaderParser(const std::string& file) : file_(file) {}

  absl::Status Consume(const Words& words) {
    if (words[0] == "comment" || words[0] == "obj_info") return absl::OkStatus();
    if (words[0] == "format") return Format(words);
    if (words[0] == "element") return Element(words);
    if (words[0] == "property") return Property(words);
    return Error("header entry", std::string(words[0]), "is not one of PLY 1.0");
  }

  absl::StatusOr<PlyHeader> Finish() {
    if (!has_format_) return Error("format", "", "is missing from the header");
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) {
        return Error(absl::StrCat("element ", Printable(element.name)), "",
                     "must have at least one property");
      }
    }
    return std::move(header_);
  }

  absl::Status Error(const std::string& field, const std::string& value,
                     const std::string& rule) const {
    return FileError(file_, {.field = field, .value = value, .rule = rule});
  }

 private:
  absl::Status Format(const Words& words) {
    static const std::map<std::string_view, PlyEncoding> kEncodings = {
        {"ascii", PlyEncoding::kAscii},
        {"binary_little_endian", PlyEncoding::kLittleEndian},
        {"binary_big_endian", PlyEncoding::kBigEndian}};
    const auto found = words.size() == 3 ? kEncodings.find(words[1]) : kEncodings.end();
    if (has_format_ || found == kEncodings.end() || words[2] != "1.0") {
      return Error("format", words.size() > 1 ? std::string(words[1]) : "",
                   "must be, once, ascii, binary_little_endian or binary_big_endian, then 1.0");
    }
    has_format_ = true;
    header_.encoding = found->second;
    return absl::OkStatus();
  }

  absl::Status Element(const Words& words) {
    if (words.size() != 3) {
      return Error("element", words.size() > 1 ? std::string(words[1]) : "",
                   "must have a name and a count");
    }
    PlyElement element{.name = std::string(words[1])};
    char bytes[sizeof(element.count)];
    const bool number = ParseScalar(words[2], Scalar::kI64, bytes);
    if (number) std::memcpy(&element.count, bytes, sizeof(bytes));
    if (!number || element.count < 0) {
      return Error(absl::StrCat("count of element ", Printable(element.name)),
                   std::string(words[2]), "must be an integer of at least 0");
    }
    const bool twice =
        std::any_of(header_.elements.begin(), header_.elements.end(),
                    [&](const PlyElement& other) { return other.name == element.name; });
    if (twice) return Error("element", element.name, "must not appear twice");
    if (header_.elements.size() == kMaxElements) {
      return Error("element", element.name, absl::StrCat("must be one of at most ", kMaxElements));
    }
    header_.elements.push_back(std::move(element));
    return absl::OkStatus();
  }

  absl::Status Property(const Words& words) {
    if (header_.elements.empty()) return Error("property", "", "must follow an element");
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (!is_list && words.size() != 3) {
      return Error("property", std::string(words.back()),
                   "must be a type and a name, or list, two types and a name");
    }
    PlyProperty property{.name = std::string(words.back())};
    const auto type = ScalarOf(words[words.size() - 2]);
    const auto count = is_list ? ScalarOf(words[2]) : std::optional(Scalar::kU8);
    if (!type || !count || !IsInteger(*count)) {
      return Error(absl::StrCat("type of property ", Printable(property.name)),
                   std::string(words[is_list && type ? 2 : words.size() - 2]),
                   "must be one of PLY 1.0, an integer where it counts a list");
    }
    property.type = *type;
    if (is_list) property.list_count = count;
    std::vector<PlyProperty>& all = header_.elements.back().properties;
    if (all.size() == kMaxProperties) {
      return Error("property", property.name,
                   absl::StrCat("must be one of at most ", kMaxProperties, " of an element"));
    }
    if (std::any_of(all.begin(), all.end(),
                    [&](const PlyProperty& other) { return other.name == property.name; })) {
      return Error("property", property.name, "must not appear twice in an element");
    }
    all.push_back(std::move(property));
    return absl::OkStatus();
  }

  const std::string& file_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

std::size_t PlyElement::MinRowBytes(PlyEncoding encoding) const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    // In ascii a number takes at least one character and a separator.
    bytes +=
        encoding == PlyEncoding::kAscii ? 2 : SizeOf(property.list_count.value_or(property.type));
  }
  return bytes;
}

absl::StatusOr<PlyHeader> ParsePlyHeader(TextCursor& cursor, const std::string& file) {
  HeaderParser parser(file);
  const auto magic = cursor.NextWholeLine();
  if (!magic || *magic != "ply") {
    return parser.Error("first line", std::string(magic.value_or("").substr(0, 12)),
                        "must be \"ply\"");
  }
  while (const auto line = cursor.NextWholeLine()) {
    const Words words = SplitWords(*line);
    if (words.empty()) continue;
    if (words[0] == "end_header") return parser.Finish();
    if (absl::Status status = parser.Consume(words); !status.ok()) return status;
  }
  return parser.Error("end_header", "", "is missing");
}

}  // namespace cwm::formats
