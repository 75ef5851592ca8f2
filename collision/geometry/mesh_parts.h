// Which way the parts of a mesh are wound.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// The triangles of a watertight mesh that must be turned over for its parts to be wound outward: of each
// part that lies in no other where its volume is negative, and of what lies in it along with it, so that
// a cavity stays one. With more than 1 000 parts the mesh is turned as a whole. Empty where none must be
// turned. `components` are Components(mesh).
std::vector<bool> TrianglesWoundInward(const TriangleMesh& mesh,
                                       const std::vector<std::uint32_t>& components,
                                       WorkCounter* work = nullptr);

}  // namespace cwm
