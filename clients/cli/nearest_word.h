// What somebody may have meant.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cwm::cli {

// The one of the known words that takes the fewest letters left out, put in, changed or swapped
// with the next to become; nothing where that is more than a third of them. The first of several.
std::optional<std::string> NearestWord(const std::string& word,
                                       const std::vector<std::string>& known);

}  // namespace cwm::cli
