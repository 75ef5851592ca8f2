// Reads and writes scenes of users: objects and the camera, as YAML. The format: scene_format.md.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/simulation/random_scenes.h"

namespace cwm::simulator {

// chosen: larger scenes are refused, so that a few lines of YAML cannot use up all memory.
inline constexpr int kMaxParts = 100'000;
inline constexpr int kMaxPixelsPerSide = 4096;  // twice that of depth cameras

// Reads the scene and the meshes that it names, with paths relative to the scene file.
// INVALID_ARGUMENT "FILE:LINE: FIELD is VALUE, RULE" for any error: unknown and repeated keys,
// missing or wrong types, numbers that are not finite, sizes that are not positive, repeated names,
// missing or broken meshes.
absl::StatusOr<perception::SimulatedView> ReadScene(const std::string& path);

// Writes a scene file that ReadScene reads as the same scene: shapes exactly, poses up to the
// rounding of their quaternion. Meshes and hulls are written beside it as PLY files, named after
// the scene file, the object and the part.
absl::Status WriteScene(const std::string& path, const perception::SimulatedView& view);

// The word for a role in scene files and in the ground truth: body, handle or spout.
std::string_view PieceRoleName(perception::PieceRole role);

}  // namespace cwm::simulator
