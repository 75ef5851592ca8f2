// GLB, the binary form of glTF 2.0, which viewers and modellers open.
#pragma once

#include <string>

#include "clients/formats/mesh_file.h"

namespace cwm::formats {

// The mesh as the one node of a scene. glTF's up is Y and a world's is Z: the node is turned by -90
// degrees about x, and the vertices stay as they are. Coordinates become single precision, which
// is what glTF has: half a micrometre at 8 m. The mesh must have a triangle.
std::string FormatGlbMesh(const MeshFile& mesh);

}  // namespace cwm::formats
