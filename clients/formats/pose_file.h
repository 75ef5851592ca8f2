// Poses in text files, as recorded sequences have them beside their frames.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/scene_pose.h"

namespace cwm::formats {

// The pose of x y z qx qy qz qw; the quaternion may have any length but 0.
std::optional<ScenePose> PoseFromRow(const std::array<double, 7>& row);

// A pose as a 4 x 4 matrix, row by row, or as the seven numbers x y z qx qy qz qw. INVALID_ARGUMENT
// for anything but a rigid transform of finite numbers.
absl::StatusOr<ScenePose> ParsePoseFile(std::string_view text, const std::string& file);

// Turns a recording's frame so that z is up: the pose of that frame in the world. The text is the
// direction of gravity in the recording's frame, three numbers of any length but 0.
absl::StatusOr<ScenePose> ParseGravityFile(std::string_view text, const std::string& file);

}  // namespace cwm::formats
