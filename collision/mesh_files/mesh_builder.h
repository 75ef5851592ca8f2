// Makes a mesh out of loose triangles, as files hold them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"

namespace cwm::collision {

// RESOURCE_EXHAUSTED `must have at most N triangles`.
absl::Status TooManyTriangles(std::size_t max_triangles);

// Cuts polygons into triangles. The work of a cut is the square of the corners; all of them together
// are bounded, since a file of a few polygons with many corners would take minutes.
class PolygonCutter {
 public:
  using Triangle = std::array<int, 3>;  // corners by index

  // One that is simple in its own plane is cut by ear clipping, another one into a fan. Refuses fewer
  // than 3 corners and more than 4096, and with RESOURCE_EXHAUSTED more work than so many corners
  // may take.
  absl::StatusOr<std::vector<Triangle>> Cut(const std::vector<Vector3>& corners);

 private:
  std::size_t corners_ = 0;  // of all polygons so far
  std::size_t work_ = 0;
};

// Vertices at the same place become one, in the order in which triangles use them first.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::size_t max_triangles) : max_triangles_(max_triangles) {}

  // Leaves out a triangle that uses a place twice, but counts it. Refuses corners that are not
  // finite, and more triangles than allowed.
  absl::Status Add(const std::array<Vector3, 3>& corners);

  // The same of a polygon, cut as by PolygonCutter.
  absl::Status AddPolygon(const std::vector<Vector3>& corners);

  // Refuses as many triangles at once, before anything is done for them.
  absl::Status CheckRoom(std::size_t triangles) const;

  // Refused without triangles.
  absl::StatusOr<TriangleMesh> Finish() &&;

 private:
  std::uint32_t IndexOf(const Vector3& p);

  std::size_t max_triangles_;
  std::size_t added_ = 0;
  PolygonCutter cutter_;
  TriangleMesh mesh_;
  absl::flat_hash_map<std::array<double, 3>, std::uint32_t> index_;
};

}  // namespace cwm::collision
