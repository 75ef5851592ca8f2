#include "clients/formats/format_error.h"

#include <algorithm>
#include <cctype>

#include "absl/strings/str_cat.h"

namespace cwm::formats {

std::string Printable(std::string_view text) {
  constexpr std::size_t kMaxShown = 60;  // leaves room on a line of a terminal
  std::string shown(text.substr(0, std::min(text.size(), kMaxShown)));
  std::replace_if(
      shown.begin(), shown.end(),
      [](char c) { return std::isprint(static_cast<unsigned char>(c)) == 0; }, '?');
  return text.size() > kMaxShown ? absl::StrCat(shown, "...") : shown;
}

absl::Status FileError(std::string_view file, const InvalidField& fault) {
  std::string message = absl::StrCat(std::string(file), ": ", fault.field);
  if (!fault.value.empty()) absl::StrAppend(&message, " is ", Printable(fault.value), ",");
  absl::StrAppend(&message, " ", fault.rule);
  return absl::InvalidArgumentError(message);
}

}  // namespace cwm::formats
