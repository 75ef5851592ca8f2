// Finds the mesh files that a URDF names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::formats {

// The URIs of the collision meshes of a URDF's links, each once, in the file's order. Empty if the
// text is not XML; the reader of the robot reports the error.
std::vector<std::string> CollisionMeshUris(std::string_view urdf);

// The base folders of relative and package paths.
struct RobotFolders {
  std::string urdf_folder;
  // Folders that contain packages, or are one. If empty: the URDF's folder and the three above it,
  // since a URDF is usually in PACKAGE/urdf.
  std::vector<std::string> package_folders;
};

// The file of "package://PACKAGE/REST", "file:///PATH", or a path relative to the URDF. Of a
// package it is PACKAGE/REST below the first package folder that has it; REST if the folder itself
// is PACKAGE, by its name or its package.xml; else REST in a folder up to six levels below a given
// package folder whose package.xml names PACKAGE. The Python client has the same rules.
// INVALID_ARGUMENT with the URI and the searched paths.
absl::StatusOr<std::string> FindMeshFile(std::string_view uri, const RobotFolders& folders);

}  // namespace cwm::formats
