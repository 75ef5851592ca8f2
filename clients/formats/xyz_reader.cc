#include <algorithm>
#include <cstring>
#include <optional>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/text_cursor.h"
#include "clients/formats/xyz.h"

namespace cwm::formats {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::string_view kAxes[] = {"x", "y", "z"};
// chosen: a line with more columns is not a point; also bounds the memory for a line.
constexpr std::size_t kMaxColumns = 256;

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\v\f");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\v\f") - begin + 1);
}

// Splits a line at commas or semicolons (with optional blanks beside them, and one may end the
// line) or, if there are none, at blanks. An empty word is a missing value. Returns at most one
// word too many, however long the line is.
Words SplitColumns(std::string_view line) {
  Words words;
  if (line.find_first_of(",;") == std::string_view::npos) {
    TextCursor cursor(line);
    while (words.size() <= kMaxColumns) {
      const auto word = cursor.NextWord();
      if (!word) break;
      words.push_back(*word);
    }
    return words;
  }
  for (line = Trimmed(line); !line.empty() && words.size() <= kMaxColumns;) {
    const std::size_t end = std::min(line.find_first_of(",;"), line.size());
    words.push_back(Trimmed(line.substr(0, end)));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return words;
}

// The text after "#" or "//"; empty if the line is not a comment.
std::optional<std::string_view> CommentOf(std::string_view line) {
  if (!line.starts_with("#") && !line.starts_with("//")) return std::nullopt;
  const std::size_t begin = line.find_first_not_of("#/ \t");
  return line.substr(std::min(begin, line.size()));
}

std::string FieldName(std::string_view word) {
  std::string name = absl::AsciiStrToLower(std::string(word));
  if (name.size() > 2 && name.front() == '"' && name.back() == '"') {
    name = name.substr(1, name.size() - 2);
  }
  const bool is_normal = name == "nx" || name == "ny" || name == "nz";
  return is_normal ? absl::StrCat("normal_", name.substr(1)) : name;
}

bool IsFieldName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_';
  });
}

// The names of columns if the words are valid names and include x, y and z.
std::optional<std::vector<std::string>> ColumnNames(const Words& words) {
  std::vector<std::string> names;
  for (const std::string_view word : words) names.push_back(FieldName(word));
  if (!names.empty() && names.front().empty()) names.front() = "index";  // as pandas writes it
  for (const std::string_view axis : kAxes) {
    if (std::find(names.begin(), names.end(), axis) == names.end()) return std::nullopt;
  }
  if (!std::all_of(names.begin(), names.end(), IsFieldName)) return std::nullopt;
  return names;
}

bool BeginsWithPoint(const Words& words) {
  char number[sizeof(double)];
  return words.size() >= 3 && std::all_of(words.begin(), words.begin() + 3, [&](auto word) {
           return ParseScalar(word, Scalar::kF64, number);
         });
}

// A line of one whole number: the count of the points that follow (PTS, CloudCompare's ASC).
std::optional<std::int64_t> CountIn(const Words& words) {
  std::int64_t count = 0;
  char bytes[sizeof(count)];
  if (words.size() != 1 || !ParseScalar(words.front(), Scalar::kI64, bytes)) return std::nullopt;
  std::memcpy(&count, bytes, sizeof(count));
  return count < 0 ? std::nullopt : std::optional(count);
}

class XyzReader {
 public:
  explicit XyzReader(const std::string& file) : file_(file) {}

  absl::StatusOr<CloudFile> Read(std::string_view bytes) {
    TextCursor cursor(bytes);
    while (const auto line = cursor.NextLine()) {
      ++line_;
      if (absl::Status status = ReadLine(Trimmed(*line)); !status.ok()) return status;
    }
    if (expected_ && *expected_ != cloud_.width) {
      return FileError(file_, {"number of points", absl::StrCat(cloud_.width),
                               absl::StrCat("must be ", *expected_, ", as the file counts them")});
    }
    if (cloud_.width == 0) {
      return FileError(file_, {"the file", "", "must hold at least one line with a point"});
    }
    return std::move(cloud_);
  }

 private:
  absl::Status ReadLine(std::string_view line) {
    if (line.empty()) return absl::OkStatus();
    const auto comment = CommentOf(line);
    const Words words = SplitColumns(comment.value_or(line));
    if (!begun_ && !BeginsWithPoint(words)) {
      if (auto names = ColumnNames(words)) {
        names_ = *std::move(names);
        return absl::OkStatus();
      }
    }
    if (comment) return absl::OkStatus();
    if (const auto count = CountIn(words); count && (!begun_ || expected_ == cloud_.width)) {
      expected_ = cloud_.width + *count;  // another scan begins where the last one ends
      return absl::OkStatus();
    }
    if (!begun_) {
      if (absl::Status status = Begin(); !status.ok()) return status;
    }
    return AddPoint(words);
  }

  // Begins once the columns are known.
  absl::Status Begin() {
    begun_ = true;
    exact_ = !names_.empty();
    if (!exact_) names_ = {"x", "y", "z"};
    std::set<std::string> known;
    for (const std::string& name : names_) {
      if (!known.insert(name).second) {
        return LineError("column", name, "must not be named twice");
      }
      cloud_.fields.push_back({.name = name, .type = Scalar::kF64});
    }
    if (names_.size() > kMaxColumns) {
      return LineError("number of columns", absl::StrCat("more than ", kMaxColumns),
                       absl::StrCat("must be at most ", kMaxColumns, " where they are named"));
    }
    cloud_.point_step = AssignOffsets(cloud_.fields);
    return absl::OkStatus();
  }

  absl::Status AddPoint(const Words& words) {
    const std::size_t columns = names_.size();
    if (words.size() < columns || (exact_ && words.size() > columns)) {
      return LineError("number of columns", absl::StrCat(words.size()),
                       absl::StrCat("must be ", exact_ ? "" : "at least ", columns,
                                    exact_ ? ", as the header names them" : ""));
    }
    const std::size_t begin = cloud_.bytes.size();
    cloud_.bytes.resize(begin + cloud_.point_step);
    for (std::size_t i = 0; i < columns; ++i) {
      if (!ParseScalar(words[i], Scalar::kF64, &cloud_.bytes[begin + cloud_.fields[i].offset])) {
        return LineError(names_[i], absl::StrCat("\"", Printable(words[i]), "\""),
                         "must be a number (a decimal point, no unit)");
      }
    }
    ++cloud_.width;
    return absl::OkStatus();
  }

  absl::Status LineError(const std::string& field, const std::string& value,
                         const std::string& rule) const {
    return FileError(file_, {absl::StrCat("line ", line_, " ", Printable(field)), value, rule});
  }

  const std::string& file_;
  CloudFile cloud_;
  std::vector<std::string> names_;        // of the columns
  bool exact_ = false;                    // the header defines the number of columns
  bool begun_ = false;                    // a point was read
  std::optional<std::int64_t> expected_;  // points up to here, if a line counts them
  std::int64_t line_ = 0;
};

}  // namespace

bool LooksLikeXyz(std::string_view bytes) {
  TextCursor cursor(bytes);
  while (const auto next = cursor.NextLine()) {
    const std::string_view line = Trimmed(*next);
    if (line.empty() || CommentOf(line)) continue;
    const Words words = SplitColumns(line);
    if (CountIn(words)) continue;
    return BeginsWithPoint(words) || ColumnNames(words).has_value();
  }
  return false;
}

absl::StatusOr<CloudFile> ParseXyz(std::string_view bytes, const std::string& file) {
  return XyzReader(file).Read(bytes);
}

}  // namespace cwm::formats
