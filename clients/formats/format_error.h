// How the readers and writers of this folder complain.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace cwm::formats {

// One fault: which field (as the file spells it), what it holds, what would be right.
struct Fault {
  std::string field;
  std::string value;  // empty: the field is missing or cannot be shown
  std::string rule;
};

// INVALID_ARGUMENT "FILE: FIELD is VALUE, RULE". Long or unprintable values are shortened, so that
// a hostile file cannot flood the terminal.
absl::Status FileError(std::string_view file, const Fault& fault);

// At most 60 printable characters of text; everything else becomes '?'.
std::string Printable(std::string_view text);

}  // namespace cwm::formats
