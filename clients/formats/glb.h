// GLB, the binary form of glTF 2.0, which viewers and modellers open.
#pragma once

#include <string>

#include "clients/formats/mesh_file.h"

namespace cwm::formats {

// Writes the mesh as the only node of a scene. glTF's up axis is Y and a world's is Z: the node is
// rotated by -90 degrees about x, and the vertices are unchanged. Coordinates become single
// precision as glTF requires: half a micrometre at 8 m. The mesh must have a triangle.
std::string FormatGlbMesh(const MeshFile& mesh);

}  // namespace cwm::formats
