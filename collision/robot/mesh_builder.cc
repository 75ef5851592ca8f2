#include "collision/robot/mesh_builder.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::collision {

absl::Status MeshBuilder::Add(const std::array<Vector3, 3>& corners) {
  TriangleMesh::Triangle t;
  for (int i = 0; i < 3; ++i) {
    if (!corners[i].allFinite()) return absl::InvalidArgumentError("must have finite vertices");
  }
  if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
    return absl::OkStatus();
  }
  if (mesh_.triangles.size() == max_triangles_) {
    return absl::InvalidArgumentError(
        absl::StrCat("must have at most ", max_triangles_, " triangles"));
  }
  for (int i = 0; i < 3; ++i) t[i] = IndexOf(corners[i]);
  mesh_.triangles.push_back(t);
  return absl::OkStatus();
}

absl::StatusOr<TriangleMesh> MeshBuilder::Finish() && {
  if (mesh_.triangles.empty()) return absl::InvalidArgumentError("must have triangles");
  return std::move(mesh_);
}

std::uint32_t MeshBuilder::IndexOf(const Vector3& p) {
  const auto [at, is_new] =
      index_.try_emplace({p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(mesh_.vertices.size()));
  if (is_new) mesh_.vertices.push_back(p);
  return at->second;
}

}  // namespace cwm::collision
