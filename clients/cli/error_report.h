// Reports errors to people: the error, its reason, and what to do next.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>

#include "absl/status/status.h"

namespace cwm::cli {

// The facts about the failed command that the hint depends on.
struct FailedCommand {
  std::string name;                                      // "distance"
  std::string address;                                   // the server's
  std::optional<std::string> suggestion = std::nullopt;  // the known name nearest to a mistyped one
  std::string program = "cwm";
};

// Prints "PROGRAM: ERROR", a line for each field at fault, the reason, and a hint.
void ReportError(const absl::Status& status, const FailedCommand& command, std::ostream& err);

}  // namespace cwm::cli
