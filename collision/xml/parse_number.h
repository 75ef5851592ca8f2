// Numbers in the text files that describe robots.
#pragma once

#include <optional>
#include <string_view>

namespace cwm::collision {

// Parses a whole word as a decimal number. "nan" and "inf" are numbers; an overflow is infinite.
std::optional<double> ParseNumber(std::string_view word);

}  // namespace cwm::collision
