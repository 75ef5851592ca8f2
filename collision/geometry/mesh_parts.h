// What hangs together in a mesh, and which way it is wound.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// For each triangle which part of the surface it is of, as ComponentPoints has them: 0, 1, ... in the
// order of their first triangles.
std::vector<std::uint32_t> Components(const TriangleMesh& mesh);

// A watertight mesh with its parts wound outward: each that lies in no other is turned over where its
// volume is negative, and what lies in it along with it, so that a cavity stays one. With more than
// 1 000 parts it is turned as a whole.
TriangleMesh WoundOutward(TriangleMesh mesh);

}  // namespace cwm
