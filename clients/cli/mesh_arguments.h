// Mesh files as shapes of objects: which files are such, in which unit and which way up.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "clients/meshes/mesh_reading.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

struct MeshArguments {
  double scale = 1;                       // metres a unit of the file
  std::optional<meshes::UpAxis> up = {};  // nothing: what the file says
};

// In a group of that name of the help.
void AddMeshOptions(CLI::App& command, const std::string& group, MeshArguments& arguments);

// The mesh of a file in metres, Z up. Vertices at the same place are one. INVALID_ARGUMENT names
// file, place and rule; a usage error for a scale that is none.
absl::StatusOr<TriangleMesh> ParseMeshFile(std::string_view bytes, const std::string& file,
                                           const MeshArguments& arguments);

// A mesh that is too long for anything that a robot reaches is most likely in millimetres: what to
// warn of, or nothing.
std::optional<std::string> SizeWarning(const TriangleMesh& mesh, const std::string& file);

// Stores the mesh with the server, and shows how far that is.
absl::StatusOr<cwm::v1::ShapePart> UploadMesh(Session& session, const TriangleMesh& mesh);

}  // namespace cwm::cli
