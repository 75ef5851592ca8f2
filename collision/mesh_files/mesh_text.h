// The lines of mesh files that are text.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "collision/geometry/pose.h"

namespace cwm::collision {

// Walks over the lines that have words. Lines end at "\n", whatever stands before it; a "\" at the
// end of a line joins it with the next.
class MeshText {
 public:
  explicit MeshText(std::string_view text) : rest_(text) {}

  // Goes to the next line with words; false at the end.
  bool Next();

  std::size_t words() const { return words_.size(); }
  std::string_view word(std::size_t i) const { return words_[i]; }
  // Whether the first word is this one, in any case of letters.
  bool Is(std::string_view keyword) const;
  // The three words from there on as numbers; they may be infinite or none.
  std::optional<Vector3> VectorAt(std::size_t first) const;

  // `line 7: RULE`.
  absl::Status Fault(std::string_view rule) const;

 private:
  void AppendWords(std::string_view line);

  std::string_view rest_;
  std::vector<std::string_view> words_;
  std::size_t line_ = 0;
};

}  // namespace cwm::collision
