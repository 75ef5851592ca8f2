// Error messages of the readers and writers of this folder.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace cwm::formats {

// A fault: the field (as the file spells it), its value, and the rule.
struct InvalidField {
  std::string field;
  std::string value;  // empty: missing or not printable
  std::string rule;
};

// INVALID_ARGUMENT "FILE: FIELD is VALUE, RULE". Long or unprintable values are shortened, so that
// a hostile file cannot flood the terminal.
absl::Status FileError(std::string_view file, const InvalidField& fault);

// At most 60 printable characters of text; everything else becomes '?'.
std::string Printable(std::string_view text);

}  // namespace cwm::formats
