#include "clients/formats/pcd_header.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"

namespace cwm::formats {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::int64_t kMaxExtent = std::numeric_limits<std::int32_t>::max();

// The header's entries: the words after each key.
class HeaderEntries {
 public:
  HeaderEntries(std::map<std::string, Words> words, std::string file)
      : words_(std::move(words)), file_(std::move(file)) {}

  bool Has(const std::string& key) const { return words_.count(key) != 0; }

  absl::StatusOr<Words> Get(const std::string& key) const {
    const auto found = words_.find(key);
    if (found == words_.end()) return Error(key, "", "is missing from the header");
    return found->second;
  }

  // One word for each of `count` fields.
  absl::StatusOr<Words> PerField(const std::string& key, std::size_t count) const {
    auto words = Get(key);
    if (words.ok() && words->size() != count) {
      return Error(absl::StrCat("number of ", key, " entries"), absl::StrCat(words->size()),
                   absl::StrCat("must be that of FIELDS, ", count));
    }
    return words;
  }

  absl::StatusOr<std::int64_t> Integer(const std::string& key, std::int64_t least,
                                       std::int64_t most) const {
    const auto words = Get(key);
    if (!words.ok()) return words.status();
    if (words->size() != 1) {
      return Error(absl::StrCat("number of ", key, " entries"), absl::StrCat(words->size()),
                   "must be 1");
    }
    return ParseInteger(key, words->front(), least, most);
  }

  absl::StatusOr<std::int64_t> ParseInteger(const std::string& key, std::string_view word,
                                            std::int64_t least, std::int64_t most) const {
    std::int64_t value = 0;
    char bytes[sizeof(value)];
    if (ParseScalar(word, Scalar::kI64, bytes)) {
      std::memcpy(&value, bytes, sizeof(value));
      if (value >= least && value <= most) return value;
    }
    return Error(key, std::string(word),
                 absl::StrCat("must be an integer from ", least, " to ", most));
  }

  absl::Status Error(const std::string& field, const std::string& value,
                     const std::string& rule) const {
    return FileError(file_, {.field = field, .value = value, .rule = rule});
  }

 private:
  std::map<std::string, Words> words_;
  std::string file_;
};

bool IsKey(std::string_view word) {
  for (const std::string_view key : {"VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH",
                                     "HEIGHT", "VIEWPOINT", "POINTS", "DATA"}) {
    if (word == key) return true;
  }
  return false;
}

// Collects the lines up to and including DATA.
absl::StatusOr<HeaderEntries> CollectEntries(TextCursor& cursor, const std::string& file) {
  std::map<std::string, Words> entries;
  const bool magic =
      cursor.rest().substr(0, 6) == "# .PCD" || cursor.rest().substr(0, 7) == "VERSION";
  if (!magic) {
    return FileError(file, {"first line", std::string(cursor.rest().substr(0, 12)),
                            "must start with \"# .PCD\" or \"VERSION\""});
  }
  while (const auto line = cursor.NextWholeLine()) {
    Words words = SplitWords(*line);
    if (words.empty() || words.front().front() == '#') continue;
    const std::string key(words.front());
    if (!IsKey(key)) return FileError(file, {"header entry", key, "is not one of PCD 0.7"});
    words.erase(words.begin());
    if (!entries.emplace(key, std::move(words)).second) {
      return FileError(file, {key, "", "appears twice in the header"});
    }
    if (key == "DATA") return HeaderEntries(std::move(entries), file);
  }
  return FileError(file, {"DATA", "", "is missing: the header ends before it"});
}

std::optional<Scalar> ScalarOf(std::string_view type, std::string_view size) {
  static const std::map<std::string, Scalar, std::less<>> kScalars = {
      {"I1", Scalar::kI8},  {"U1", Scalar::kU8},  {"I2", Scalar::kI16}, {"U2", Scalar::kU16},
      {"I4", Scalar::kI32}, {"U4", Scalar::kU32}, {"I8", Scalar::kI64}, {"U8", Scalar::kU64},
      {"F4", Scalar::kF32}, {"F8", Scalar::kF64}};
  const auto found = kScalars.find(std::string(type) + std::string(size));
  if (found == kScalars.end()) return std::nullopt;
  return found->second;
}

absl::StatusOr<std::vector<CloudField>> ParseFields(const HeaderEntries& entries) {
  const auto names = entries.Get("FIELDS");
  if (!names.ok()) return names.status();
  if (names->empty()) return entries.Error("FIELDS", "", "must name at least one field");
  const auto types = entries.PerField("TYPE", names->size());
  if (!types.ok()) return types.status();
  const auto sizes = entries.PerField("SIZE", names->size());
  if (!sizes.ok()) return sizes.status();
  auto counts = absl::StatusOr<Words>(Words(names->size(), "1"));
  if (entries.Has("COUNT")) counts = entries.PerField("COUNT", names->size());
  if (!counts.ok()) return counts.status();

  std::vector<CloudField> fields;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < names->size(); ++i) {
    const std::string name((*names)[i]);
    if (name != "_" && !seen.insert(name).second) {
      return entries.Error("FIELDS", name, "must not appear twice");
    }
    const auto type = ScalarOf((*types)[i], (*sizes)[i]);
    if (!type) {
      return entries.Error(absl::StrCat("TYPE and SIZE of field ", Printable(name)),
                           absl::StrCat(std::string((*types)[i]), " ", std::string((*sizes)[i])),
                           "must be I or U with 1, 2, 4 or 8, or F with 4 or 8");
    }
    const auto count = entries.ParseInteger(absl::StrCat("COUNT of field ", Printable(name)),
                                            (*counts)[i], 1, kMaxPcdPointStep);
    if (!count.ok()) return count.status();
    fields.push_back({.name = name, .type = *type, .count = static_cast<std::size_t>(*count)});
  }
  return fields;
}

absl::Status ParseExtent(const HeaderEntries& entries, PcdHeader& header) {
  const auto width = entries.Integer("WIDTH", 0, kMaxExtent);
  if (!width.ok()) return width.status();
  const auto height = entries.Integer("HEIGHT", 0, kMaxExtent);
  if (!height.ok()) return height.status();
  header.width = *width;
  header.height = *height;  // two 31-bit numbers, so the product fits
  if (!entries.Has("POINTS")) return absl::OkStatus();
  const auto points = entries.Integer("POINTS", 0, std::numeric_limits<std::int64_t>::max());
  if (!points.ok()) return points.status();
  if (*points == header.points()) return absl::OkStatus();
  return entries.Error("POINTS", absl::StrCat(*points),
                       absl::StrCat("must be WIDTH x HEIGHT, ", header.points()));
}

absl::Status ParseViewpoint(const HeaderEntries& entries, PcdHeader& header) {
  if (!entries.Has("VIEWPOINT")) return absl::OkStatus();
  const auto words = entries.Get("VIEWPOINT");
  if (words->size() != header.viewpoint.size()) {
    return entries.Error("number of VIEWPOINT entries", absl::StrCat(words->size()),
                         "must be 7: tx ty tz qw qx qy qz");
  }
  for (std::size_t i = 0; i < words->size(); ++i) {
    char bytes[sizeof(double)];
    if (!ParseScalar((*words)[i], Scalar::kF64, bytes) ||
        !std::isfinite(ToDouble(bytes, Scalar::kF64))) {
      return entries.Error("VIEWPOINT", std::string((*words)[i]), "must be a finite number");
    }
    header.viewpoint[i] = ToDouble(bytes, Scalar::kF64);
  }
  return absl::OkStatus();
}

absl::Status ParseEncoding(const HeaderEntries& entries, PcdHeader& header) {
  const Words words = *entries.Get("DATA");
  const std::string data = words.size() == 1 ? std::string(words.front()) : "";
  if (data == "ascii") {
    header.encoding = PcdEncoding::kAscii;
  } else if (data == "binary") {
    header.encoding = PcdEncoding::kBinary;
  } else if (data == "binary_compressed") {
    header.encoding = PcdEncoding::kBinaryCompressed;
  } else {
    return entries.Error("DATA", data, "must be ascii, binary or binary_compressed");
  }
  return absl::OkStatus();
}

absl::Status CheckVersion(const HeaderEntries& entries) {
  const auto words = entries.Get("VERSION");
  if (!words.ok()) return absl::OkStatus();  // as PCL reads it: the first line says PCD
  const std::string version = words->size() == 1 ? std::string(words->front()) : "";
  if (version == "0.7" || version == ".7") return absl::OkStatus();
  return entries.Error("VERSION", version, "must be 0.7");
}

}  // namespace

absl::StatusOr<PcdHeader> ParsePcdHeader(TextCursor& cursor, const std::string& file) {
  const auto entries = CollectEntries(cursor, file);
  if (!entries.ok()) return entries.status();
  if (absl::Status version = CheckVersion(*entries); !version.ok()) return version;
  PcdHeader header;
  auto fields = ParseFields(*entries);
  if (!fields.ok()) return fields.status();
  header.fields = *std::move(fields);
  header.point_step = AssignOffsets(header.fields);
  if (header.point_step > kMaxPcdPointStep) {
    return entries->Error("size of a point", absl::StrCat(header.point_step, " bytes"),
                          absl::StrCat("must be at most ", kMaxPcdPointStep));
  }
  for (const auto& parse : {ParseExtent, ParseViewpoint, ParseEncoding}) {
    if (absl::Status status = parse(*entries, header); !status.ok()) return status;
  }
  return header;
}

}  // namespace cwm::formats
