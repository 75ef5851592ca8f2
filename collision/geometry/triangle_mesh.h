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
// directions: the mesh then bounds a volume and "inside" has a meaning. Edges are the same where
// their ends are at the same places, whether or not the triangles share indices: an STL never does.
// Takes a second for some millions of triangles.
bool IsWatertight(const TriangleMesh& mesh, WorkCounter* work = nullptr);
// The same of indices alone, as hulls have it. What is so is watertight.
bool SharesEdges(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// One vertex of each part of the surface that hangs together; vertices at the same place hang
// together whether or not they share an index. Vertices without a triangle are no part.
std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// For each triangle which of these parts it is of: 0, 1, ... in the order of their first triangles.
std::vector<std::uint32_t> Components(const TriangleMesh& mesh, WorkCounter* work = nullptr);
// The first corner of each part.
std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh,
                                     const std::vector<std::uint32_t>& components);

// Volume by the divergence theorem; positive for an outward-wound watertight mesh.
double SignedVolume_m3(const TriangleMesh& mesh, WorkCounter* work = nullptr);

// The convex hull of points as an outward-wound watertight mesh whose corners are among them: no point
// lies beyond it by more than 1e-12 of the extent. Empty when they span no volume: when all lie within
// that of a plane. Coordinates must be finite.
TriangleMesh ConvexHull3(const std::vector<Vector3>& points, WorkCounter* work = nullptr);

}  // namespace cwm
