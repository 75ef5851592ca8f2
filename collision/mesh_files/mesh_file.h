// Mesh files: STL (text and binary), OBJ, Collada (DAE) and GLB.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::collision {

// The mesh of a file, of which the name's ending tells the format, in the file's own frame:
// - All nodes of the scene together, each with its transform; one that mirrors turns its triangles
//   round, so that outside stays outside. Polygons become triangles; points and
//   lines are left out, but that a GLB with some is refused.
// - Units are metres, but that the <unit> of a Collada file is applied. No axis is turned up: Z of
//   the file is Z of the mesh, whatever <up_axis> says. For the links of robots RViz and MoveIt do
//   the same; what either shows is what is checked here. Who wants up to be up asks UpAxisOf.
// - Vertices at the same place become one (an STL names each corner anew). Triangles that then use a
//   vertex twice are left out; those without an area but with three corners stay, since the surface
//   would gape without them.
//
// Refuses empty and malformed files, other formats, vertices that are not finite, and with
// RESOURCE_EXHAUSTED more than the limits say. Nothing but `bytes` is read: materials, textures and external buffers are never
// looked for on a disk. The message of a refusal is the rule alone, to be put behind a place.
absl::StatusOr<TriangleMesh> ReadMeshFile(std::string_view bytes, std::string_view name,
                                          const MeshFileLimits& limits = {});

// Which axis of the file is up: Y of every GLB, as its standard has it, what <up_axis> says of a
// Collada file and Y where that says nothing, Z of other formats, which have no word for it.
// Refuses what is not to be read as Collada.
absl::StatusOr<UpAxis> UpAxisOf(std::string_view bytes, std::string_view name,
                                const MeshFileLimits& limits = {});

// The mesh of a file of which that axis is up, turned so that Z is: the turns that Collada's manual
// has for its three kinds of files.
TriangleMesh WithZUp(UpAxis up, TriangleMesh mesh);

}  // namespace cwm::collision
