// Mesh files: STL (text and binary), OBJ, Collada (DAE) and GLB.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/mesh_files/mesh_file_limits.h"
#include "collision/mesh_files/up_axis.h"

namespace cwm::collision {

// Reads the mesh of a file, in the file's own frame. The ending of `name` gives the format.
// - All nodes of the scene are merged, each with its transform. A mirroring transform reverses the
//   order of the corners, so that the outside stays outside. Polygons become triangles. Points and
//   lines are left out, except that a GLB file with any is refused.
// - Units are metres; the <unit> of a Collada file is applied. Axes are not changed: Z of the file
//   is Z of the mesh, whatever <up_axis> says. RViz and MoveIt do the same for the links of robots,
//   so the mesh checked here is the one that they show. UpAxisOf and RotateToZUp turn a mesh
//   upright.
// - Vertices at the same position are merged (an STL file repeats each corner). Triangles that then
//   use a vertex twice are left out. Triangles with three distinct corners but no area are kept,
//   because the surface would have gaps without them.
//
// Refuses empty and malformed files, other formats, vertices that are not finite, and with
// RESOURCE_EXHAUSTED files that exceed the limits. Only `bytes` is read: materials, textures and
// external buffers are never looked up on a disk. The message of a refusal is the rule alone; the
// caller puts a location in front of it.
absl::StatusOr<TriangleMesh> ReadMeshFile(std::string_view bytes, std::string_view name,
                                          const MeshFileLimits& limits = {});

// The up axis of a file: Y for GLB, as its standard defines; the axis in <up_axis> for Collada, Y
// if there is none; Z for other formats, which do not define one. Refuses a malformed Collada file.
absl::StatusOr<UpAxis> UpAxisOf(std::string_view bytes, std::string_view name,
                                const MeshFileLimits& limits = {});

// Rotates a mesh whose up axis is `up` so that Z is up, in the way that Collada's specification
// defines for its three up axes.
TriangleMesh RotateToZUp(UpAxis up, TriangleMesh mesh);

}  // namespace cwm::collision
