// The order of names in lists for people.
#pragma once

#include <string_view>

namespace cwm::cli {

// True if `a` comes before `b` where runs of digits are compared as whole numbers: object_2 before
// object_10. A strict order of all texts: numbers that differ by leading zeros alone, "1" and "01",
// are ordered by their bytes. Answers of the API and JSON are ordered by the bytes of names
// instead.
bool NaturalLess(std::string_view a, std::string_view b);

}  // namespace cwm::cli
