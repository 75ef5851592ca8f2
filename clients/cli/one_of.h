// Validators for the arguments of options: one of some words, a time.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace cwm::cli {

// Accepts one of the words in upper or lower case. The error is e.g. "--kind: "spoon" must be
// object, residual or user". For Option::transform of an option that stores an enum.
template <class Enum>
CLI::Validator OneOf(std::map<std::string, Enum> values) {
  const auto check = [values = std::move(values)](std::string& word) -> std::string {
    const auto found = values.find(absl::AsciiStrToLower(word));
    if (found != values.end()) {
      word = std::to_string(static_cast<int>(found->second));
      return "";
    }
    std::vector<std::string> names;
    for (const auto& [name, value] : values) names.push_back(name);
    const std::string last = names.back();
    names.pop_back();
    return absl::StrCat("\"", word, "\" must be ", absl::StrJoin(names, ", "), " or ", last);
  };
  return CLI::Validator(check, "");
}

// The error is e.g. "--deadline: "0" must be a number of seconds, more than 0". For Option::check.
inline std::string PositiveSeconds(const std::string& text) {
  double seconds = 0;
  if (absl::SimpleAtod(text, &seconds) && seconds > 0) return "";
  return absl::StrCat("\"", text, "\" must be a number of seconds, more than 0");
}

}  // namespace cwm::cli
