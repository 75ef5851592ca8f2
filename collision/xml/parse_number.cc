#include "collision/xml/parse_number.h"

#include "absl/strings/numbers.h"

namespace cwm::collision {

std::optional<double> ParseNumber(std::string_view word) {
  double value = 0;
  // Abseil accepts hexadecimal numbers, which other readers of these files do not.
  if (word.find_first_of("xX") != std::string_view::npos) return std::nullopt;
  if (!absl::SimpleAtod({word.data(), word.size()}, &value)) return std::nullopt;
  return value;
}

}  // namespace cwm::collision
