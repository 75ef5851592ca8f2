// The winding of a mesh's connected components.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

// For each triangle of a watertight mesh, true if it must be turned over so that the mesh is wound
// outward. An outermost component with negative volume is turned together with all components
// inside it, so that a cavity stays a cavity. A mesh of more than 1 000 components is turned as a
// whole. Empty if no triangle must be turned. `components` is the result of
// ConnectedComponents(mesh).
std::vector<bool> TrianglesWoundInward(const TriangleMesh& mesh,
                                       const std::vector<std::uint32_t>& components,
                                       WorkCounter* work = nullptr);

}  // namespace cwm
