// Mesh files as shapes of objects: recognising them, units and axes.
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
  double scale = 1;                       // metres per unit of the file
  std::optional<meshes::UpAxis> up = {};  // empty: as given by the file
};

// Adds the options to the help's group of that name.
void AddMeshOptions(CLI::App& command, const std::string& group, MeshArguments& arguments);

// The mesh of a file in metres, Z up. Vertices at the same place are merged. INVALID_ARGUMENT with
// file, place and rule; a usage error for an invalid scale.
absl::StatusOr<TriangleMesh> ParseMeshFile(std::string_view bytes, const std::string& file,
                                           const MeshArguments& arguments);

// A warning if the mesh is longer than anything that a robot reaches, in which case it is probably
// in millimetres; empty otherwise.
std::optional<std::string> SizeWarning(const TriangleMesh& mesh, const std::string& file);

// Stores the mesh on the server and shows the progress.
absl::StatusOr<cwm::v1::ShapePart> UploadMesh(Session& session, const TriangleMesh& mesh);

// A mesh of a file that the server stores.
struct SentMesh {
  cwm::v1::ShapePart part;
  std::string text;  // "a mesh of 12 triangles, closed", see MeshSolid
};
// Reads a file as ParseMeshFile does, sends the mesh and shows the progress. Warns of a mesh that
// is too long, is open, or has holes that the server closes.
absl::StatusOr<SentMesh> SendMeshFile(Session& session, std::string_view bytes,
                                      const std::string& file, const MeshArguments& arguments);

}  // namespace cwm::cli
