// Line by line reading of mesh files in text formats.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "collision/geometry/pose.h"

namespace cwm::collision {

// Iterates over the lines that have words. A line ends at "\n" or "\r\n"; a "\" at its end joins it
// with the next line.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}

  // Goes to the next line with words; false at the end.
  bool Next();

  std::size_t words() const { return words_.size(); }
  std::string_view word(std::size_t i) const { return words_[i]; }
  // True if the first word is `keyword`, which is in lower case, ignoring the case of the word.
  bool Is(std::string_view keyword) const;
  // Three words, beginning with word `first`, as numbers, which may be infinite or NaN. Empty if
  // they are not numbers.
  std::optional<Vector3> VectorAt(std::size_t first) const;

  // The error `line 7: RULE`.
  absl::Status Fault(std::string_view rule) const;

 private:
  void AppendWords(std::string_view line);

  std::string_view rest_;
  std::vector<std::string_view> words_;
  std::size_t line_ = 0;
};

}  // namespace cwm::collision
