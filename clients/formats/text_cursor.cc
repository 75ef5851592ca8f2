#include "clients/formats/text_cursor.h"

#include <algorithm>

namespace cwm::formats {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

}  // namespace

std::vector<std::string_view> SplitWords(std::string_view line) {
  std::vector<std::string_view> words;
  TextCursor cursor(line);
  while (const auto word = cursor.NextWord()) words.push_back(*word);
  return words;
}

std::optional<std::string_view> TextCursor::NextLine() {
  if (rest_.empty()) return std::nullopt;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::optional<std::string_view> TextCursor::NextWholeLine() {
  if (rest_.find('\n') == std::string_view::npos) return std::nullopt;
  return NextLine();
}

std::optional<std::string_view> TextCursor::NextWord() {
  const std::size_t begin = rest_.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) {
    rest_ = {};
    return std::nullopt;
  }
  const std::size_t end = std::min(rest_.find_first_of(kBlanks, begin), rest_.size());
  const std::string_view word = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  return word;
}

std::optional<std::string_view> TextCursor::NextBytes(std::size_t count) {
  if (count > rest_.size()) return std::nullopt;
  const std::string_view bytes = rest_.substr(0, count);
  rest_.remove_prefix(count);
  return bytes;
}

bool TextCursor::OnlyPaddingLeft() const {
  return std::all_of(rest_.begin(), rest_.end(),
                     [](char c) { return c == '\0' || kBlanks.find(c) != std::string_view::npos; });
}

}  // namespace cwm::formats
