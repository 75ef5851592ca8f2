// Builds an indexed mesh from the loose triangles of a file.
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

// Triangulates polygons. The work for one polygon grows with the square of its corners. The work
// for all polygons together is limited, because a file with a few polygons of many corners would
// take minutes.
class PolygonTriangulator {
 public:
  using Triangle = std::array<int, 3>;  // indices of corners

  // Triangulates a polygon by ear clipping if it is simple in its own plane, else as a fan. Refuses
  // fewer than 3 and more than 4096 corners, and with RESOURCE_EXHAUSTED more work in total than
  // the corners so far allow.
  absl::StatusOr<std::vector<Triangle>> Triangulate(const std::vector<Vector3>& corners);

 private:
  std::size_t corners_ = 0;  // of all polygons so far
  std::size_t work_ = 0;
};

// Merges vertices at the same position, in the order in which triangles first use them.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::size_t max_triangles) : max_triangles_(max_triangles) {}

  // Adds a triangle, unless two of its corners coincide; it counts towards the limit either way.
  // Refuses corners that are not finite, and more triangles than allowed.
  absl::Status Add(const std::array<Vector3, 3>& corners);

  // Adds a polygon, triangulated by PolygonTriangulator.
  absl::Status AddPolygon(const std::vector<Vector3>& corners);

  // RESOURCE_EXHAUSTED if adding that many triangles would exceed the limit.
  absl::Status CheckCapacity(std::size_t triangles) const;

  // The mesh; refused if it has no triangles.
  absl::StatusOr<TriangleMesh> Finish() &&;

 private:
  std::uint32_t IndexOf(const Vector3& p);

  std::size_t max_triangles_;
  std::size_t added_ = 0;
  PolygonTriangulator triangulator_;
  TriangleMesh mesh_;
  absl::flat_hash_map<std::array<double, 3>, std::uint32_t> index_;
};

}  // namespace cwm::collision
