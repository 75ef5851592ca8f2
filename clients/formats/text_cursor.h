// Walks over a file that is held in memory: text lines and words first, then maybe raw bytes.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace cwm::formats {

// The words of a line, which spaces and tabs separate.
std::vector<std::string_view> SplitWords(std::string_view line);

class TextCursor {
 public:
  // The bytes must outlive the cursor.
  explicit TextCursor(std::string_view bytes) : rest_(bytes) {}

  // Everything not yet consumed.
  std::string_view rest() const { return rest_; }

  // The next line without its end ("\n" or "\r\n"); nothing at the end. A last line without an end
  // counts.
  std::optional<std::string_view> NextLine();

  // Like NextLine, but only when the line has an end: a header cut short is not a header.
  std::optional<std::string_view> NextWholeLine();

  // The next word, over line ends; nothing when only white space is left.
  std::optional<std::string_view> NextWord();

  // Exactly `count` bytes; nothing when fewer are left.
  std::optional<std::string_view> NextBytes(std::size_t count);

  // True when nothing but white space and zero bytes is left: padding, no data.
  bool OnlyPaddingLeft() const;

 private:
  std::string_view rest_;
};

}  // namespace cwm::formats
