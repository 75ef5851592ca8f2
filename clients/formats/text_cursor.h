// Walks over a file in memory: lines and words of text, then possibly raw bytes.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace cwm::formats {

// The words of a line, separated by spaces and tabs.
std::vector<std::string_view> SplitWords(std::string_view line);

class TextCursor {
 public:
  // The bytes must outlive the cursor.
  explicit TextCursor(std::string_view bytes) : rest_(bytes) {}

  // Everything not yet consumed.
  std::string_view rest() const { return rest_; }

  // The next line without its end ("
  // " or "\r
  // "); empty at the end of the file. A last line without an end counts.
  std::optional<std::string_view> NextLine();

  // Like NextLine, but requires the line's end: a truncated header is not a header.
  std::optional<std::string_view> NextWholeLine();

  // The next word, across line ends; empty if only white space is left.
  std::optional<std::string_view> NextWord();

  // Exactly `count` bytes; empty if fewer are left.
  std::optional<std::string_view> NextBytes(std::size_t count);

  // True if only padding (white space and zero bytes) is left.
  bool OnlyPaddingLeft() const;

 private:
  std::string_view rest_;
};

}  // namespace cwm::formats
