// Suggests a correction of a mistyped word.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cwm::cli {

// The known word with the fewest edits (letters removed, inserted, changed or swapped with the
// next) from `word`; empty if that is more than a third of the letters. The first of several.
std::optional<std::string> NearestWord(const std::string& word,
                                       const std::vector<std::string>& known);

}  // namespace cwm::cli
