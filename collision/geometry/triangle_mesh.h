// Indexed triangle meshes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/geometry/work_counter.h"

namespace cwm {

// Triangles wind counter-clockwise seen from outside (or from the side of the sensor, for an open
// surface): the normal of (a, b, c) is (b - a) x (c - a).
struct TriangleMesh {
  using Triangle = std::array<std::uint32_t, 3>;
  std::vector<Vector3> vertices;  // metres
  std::vector<Triangle> triangles;

  friend bool operator==(const TriangleMesh&, const TriangleMesh&) = default;
};

// True when every edge is shared by exactly two triangles that run through it in opposite
// directions: the mesh then bounds a volume and "inside" has a meaning. Edges are compared by the
// positions of their ends, since the triangles need not share indices (in an STL file they never
// do). Takes a second for some millions of triangles.
bool IsWatertight(const TriangleMesh& mesh, WorkCounter* work = nullptr);
// The same test by indices alone, as hulls satisfy it. It implies IsWatertight.
bool IsWatertightByIndex(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// For each vertex the index of a vertex at the same position, one index for all vertices there.
// Empty if `work` ended the search.
std::vector<std::uint32_t> WeldedVertices(const std::vector<Vector3>& vertices,
                                          WorkCounter* work = nullptr);

// One vertex of each connected component of the surface. Vertices at the same position are
// connected whether or not they share an index. Vertices without a triangle belong to no component.
std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// The component of each triangle: 0, 1, ... in the order of the components' first triangles.
std::vector<std::uint32_t> ConnectedComponents(const TriangleMesh& mesh,
                                               WorkCounter* work = nullptr);
// The first corner of each component.
std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh,
                                     const std::vector<std::uint32_t>& components);

// Volume by the divergence theorem; positive for an outward-wound watertight mesh.
double SignedVolume_m3(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// The convex hull of points as an outward-wound watertight mesh whose corners are among the points.
// No point lies outside it by more than 1e-12 of the extent. Empty if the points span no volume,
// that is if all lie within 1e-12 of the extent of a plane. Coordinates must be finite.
TriangleMesh ConvexHull3(const std::vector<Vector3>& points, WorkCounter* work = nullptr);

}  // namespace cwm
