#include "collision/mesh_files/line_reader.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "absl/strings/str_cat.h"
#include "collision/xml/parse_number.h"

namespace cwm::collision {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

char Lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

}  // namespace

bool LineReader::Next() {
  words_.clear();
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    const bool goes_on = line.ends_with('\\');
    if (goes_on) line.remove_suffix(1);
    AppendWords(line);
    if (!goes_on && !words_.empty()) return true;
  }
  return !words_.empty();
}

void LineReader::AppendWords(std::string_view line) {
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) return;
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    words_.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool LineReader::Is(std::string_view keyword) const {
  const std::string_view first = words_.front();
  return std::equal(first.begin(), first.end(), keyword.begin(), keyword.end(),
                    [](char a, char b) { return Lower(a) == b; });
}

std::optional<Vector3> LineReader::VectorAt(std::size_t first) const {
  if (words_.size() < first + 3) return std::nullopt;
  Vector3 vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> value = ParseNumber(words_[first + i]);
    if (!value.has_value()) return std::nullopt;
    vector[static_cast<int>(i)] = *value;
  }
  return vector;
}

absl::Status LineReader::Fault(std::string_view rule) const {
  return absl::InvalidArgumentError(absl::StrCat("line ", line_, ": ", std::string(rule)));
}

}  // namespace cwm::collision
