// Closes meshes that are open by a defect of the file only.
#pragma once

#include <cstddef>
#include <optional>

#include "collision/geometry/triangle_mesh.h"

namespace cwm {

struct ClosedMesh {
  TriangleMesh mesh;            // watertight
  std::size_t repeated = 0;     // triangles left out, since an equal one is there
  std::size_t split_edges = 0;  // edges split at a vertex that lies on them
};

// The mesh without repeated triangles, and with each open edge split at the vertices of other open
// edges that lie on it within 1e-7 of the mesh's extent: a T-junction is no hole. Vertices at the
// same position are one. Empty if the mesh stays open, if it has more than some thousand open
// edges, or if `work` ended the search. For meshes that are not watertight as they are.
std::optional<ClosedMesh> Close(const TriangleMesh& mesh, WorkCounter* work = nullptr);

}  // namespace cwm
