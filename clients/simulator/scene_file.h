// Scenes from strangers: objects and the camera, as YAML. The format: scene_format.md.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "perception/simulation/random_scenes.h"

namespace cwm::simulator {

// Scenes larger than this are refused, so that a few lines of YAML cannot ask for all memory.
inline constexpr int kMostParts = 100'000;
inline constexpr int kMostPixelsPerSide = 4096;  // twice what depth cameras have

// Reads the scene and the meshes that it names, their paths relative to the scene file.
// INVALID_ARGUMENT "FILE:LINE: FIELD is VALUE, RULE" for whatever does not fit: unknown and double
// keys, missing or wrong types, numbers that are not finite, sizes that are not positive, names
// that appear twice, meshes that are missing or broken.
absl::StatusOr<perception::SimulatedView> ReadScene(const std::string& path);

// Writes a scene file that ReadScene reads back as the same scene: shapes to the last bit, poses
// but for the rounding of their quaternion. Meshes and hulls go beside it as PLY files, named after the scene file, the object and the
// part.
absl::Status WriteScene(const std::string& path, const perception::SimulatedView& view);

}  // namespace cwm::simulator
