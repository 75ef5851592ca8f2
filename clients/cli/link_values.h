// Numbers and frames of links on the command line: "panda_hand=0.02", "grip=panda_hand@0,0,0.1034".
#pragma once

#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "cwm/v1/robot_model.pb.h"

namespace cwm::cli {

inline constexpr char kPaddingForm[] = "LINK=METRES";
inline constexpr char kScaleForm[] = "LINK=FACTOR";
inline constexpr char kToolForm[] = "NAME=LINK[@X,Y,Z[,QX,QY,QZ,QW]]";
inline constexpr char kToolGroupForm[] = "NAME=GROUP";

// Usage errors name the option, the text and the form. The last "=" separates the number.
absl::StatusOr<cwm::v1::LinkPadding> ParseLinkPadding(const std::string& text);
absl::StatusOr<cwm::v1::LinkScale> ParseLinkScale(const std::string& text);
// The first "=" ends the tool's name, the last "@" begins the pose in the link's frame.
absl::StatusOr<cwm::v1::RobotTool> ParseTool(const std::string& text);
// The name of a tool and that of its group.
absl::StatusOr<std::pair<std::string, std::string>> ParseToolGroup(const std::string& text);

}  // namespace cwm::cli
