// Hypothetical changes of a query on the command line, in the form of the commands that make them.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// The forms of a change, for the help.
inline constexpr char kChangeForms[] =
    "\"move NAME POSE\", \"remove NAME\", \"attach NAME ROBOT:LINK [POSE]\", \"detach NAME\", "
    "\"allow A,B\", or a Change as JSON";

// A usage error with `option` for anything else. POSE is X,Y,Z[,QX,QY,QZ,QW]. Names with blanks can
// only be given as JSON.
absl::StatusOr<cwm::v1::Change> ParseChange(const std::string& text, const std::string& option);

}  // namespace cwm::cli
