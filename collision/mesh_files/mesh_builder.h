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

// Vertices at the same place become one, in the order in which triangles use them first.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::size_t max_triangles) : max_triangles_(max_triangles) {}

  // Leaves out a triangle that uses a place twice, but counts it. Refuses corners that are not
  // finite, and more triangles than allowed.
  absl::Status Add(const std::array<Vector3, 3>& corners);

  // The same of a polygon: one that is simple in its own plane is cut by ear clipping, another one
  // into a fan. Refuses fewer than 3 corners and more than 4096.
  absl::Status AddPolygon(const std::vector<Vector3>& corners);

  // Refused without triangles.
  absl::StatusOr<TriangleMesh> Finish() &&;

 private:
  std::uint32_t IndexOf(const Vector3& p);

  std::size_t max_triangles_;
  std::size_t added_ = 0;
  TriangleMesh mesh_;
  absl::flat_hash_map<std::array<double, 3>, std::uint32_t> index_;
};

}  // namespace cwm::collision
