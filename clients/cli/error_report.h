// Errors as people read them: what, why, what to do next.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>

#include "absl/status/status.h"

namespace cwm::cli {

// What the hint needs to know about the command that failed.
struct FailedCommand {
  std::string name;                                 // "distance"
  std::string address;                              // of the server
  std::optional<std::string> meant = std::nullopt;  // the name that a mistyped one is nearest to
  std::string program = "cwm";
};

// "PROGRAM: WHAT", a line for each field at fault, the reason, and a hint.
void ReportError(const absl::Status& status, const FailedCommand& command, std::ostream& err);

}  // namespace cwm::cli
