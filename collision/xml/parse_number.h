// Numbers as the text files of robots write them.
#pragma once

#include <optional>
#include <string_view>

namespace cwm::collision {

// A whole word as a decimal number; "nan" and "inf" are such, and what overflows is infinite.
std::optional<double> ParseNumber(std::string_view word);

}  // namespace cwm::collision
