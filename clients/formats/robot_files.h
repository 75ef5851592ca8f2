// The mesh files that a URDF names, found on this machine.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::formats {

// The URIs of the meshes that a URDF's links have as collision geometry, each once, in the order of
// the file. Empty for what is not XML: who reads the robot says what is wrong with it.
std::vector<std::string> CollisionMeshUris(std::string_view urdf);

// Where relative and package paths begin.
struct RobotFolders {
  std::string urdf_folder;
  // Folders that hold packages, or are one. Empty: the URDF's folder and the three above it, since a
  // URDF lies in PACKAGE/urdf or thereabouts.
  std::vector<std::string> package_folders;
};

// The file of "package://PACKAGE/REST" (PACKAGE/REST below the first package folder that has it, or
// REST where the folder itself is PACKAGE, by its own name or by that in its package.xml),
// "file:///PATH", or a path relative to the URDF. INVALID_ARGUMENT names the URI and where it was
// looked for.
absl::StatusOr<std::string> FindMeshFile(std::string_view uri, const RobotFolders& folders);

}  // namespace cwm::formats
