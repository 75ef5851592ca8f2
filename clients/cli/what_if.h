// Changes that a question supposes, on the command line: as the commands say that make them.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// What the help calls the forms.
inline constexpr char kChangeForms[] =
    "\"move NAME POSE\", \"remove NAME\", \"attach NAME ROBOT:LINK [POSE]\", \"detach NAME\", "
    "\"allow A,B\", or a Change as JSON";

// A usage error that names `option` for anything else. POSE is X,Y,Z[,QX,QY,QZ,QW]. What has a blank
// in its name only JSON can say.
absl::StatusOr<cwm::v1::Change> ParseChange(const std::string& text, const std::string& option);

}  // namespace cwm::cli
