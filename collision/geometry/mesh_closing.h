// Closes meshes that a defect of the file opens, and meshes with small holes.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm {

struct ClosedMesh {
  TriangleMesh mesh;               // watertight
  std::size_t repeated = 0;        // triangles left out, since an equal one is there
  std::size_t split_edges = 0;     // edges split at a vertex that lies on them
  std::vector<MeshCap> caps = {};  // of the holes that triangles of no file close
};

// The reason why a mesh stays open.
struct MeshOpening {
  std::size_t edges = 0;  // with a triangle on one side only; a lower bound if there are thousands
  std::size_t holes = 0;  // simple loops of these edges; 0 if they are no simple loops
  double largest_m = 0;   // diameter of the largest hole
  double area_share = 0;  // of all holes, in the area of the mesh
};

struct MeshClosing {
  std::optional<ClosedMesh> closed;
  MeshOpening opening = {};  // of a mesh that stays open
};

// The mesh without repeated triangles, and with each open edge split at the vertices of other open
// edges that lie on it within 1e-7 of the mesh's extent: a T-junction is no hole. Vertices at the
// same position are one.
//
// Edges that are still open then bound holes. Up to 64 holes, each with a simple boundary, are
// closed if their triangles have at most 1 % of the mesh's area together. Outside of the convex
// hulls of the boundaries, the closed mesh has the same inside as the mesh with any other surface
// in the holes that stays within these hulls: the two surfaces differ by closed ones within the
// hulls, around which the winding number of a point outside is 0.
//
// The mesh stays open if its holes are others, if it has more than some thousand open edges, or if
// `work` ended the search. For meshes that are not watertight as they are.
MeshClosing TryClose(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// The closed mesh alone; empty if the mesh stays open.
std::optional<ClosedMesh> Close(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// The mesh as a shape: closed if it is watertight or Close can close it, else open. nullopt if
// `work` ended the search.
std::optional<Mesh> SolidOf(std::shared_ptr<const TriangleMesh> mesh, WorkCounter* work = nullptr);

}  // namespace cwm
