// Holes in the surface of a mesh, and the triangles that close them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collision/geometry/shape.h"

namespace cwm {

// An edge from one vertex to another, in the direction of its triangle.
using MeshEdge = std::pair<std::uint32_t, std::uint32_t>;

// The vertices around one hole, each once, in the direction of the triangles beside it.
using BoundaryLoop = std::vector<std::uint32_t>;

// The loops of edges that have a triangle on one side only, given in ascending order. Empty if they
// are no simple loops: several begin at one vertex, or one ends where none begins.
std::optional<std::vector<BoundaryLoop>> BoundaryLoops(std::span<const MeshEdge> open_edges);

// Triangles that close a hole: one if it has three corners, else a fan about the mean of its
// corners, which is then appended to the vertices.
struct HoleFan {
  MeshCap cap;
  double area_m2 = 0;
  std::vector<TriangleMesh::Triangle> triangles;
};
HoleFan FanOf(const BoundaryLoop& loop, std::vector<Vector3>& vertices,
              WorkCounter* work = nullptr);

}  // namespace cwm
