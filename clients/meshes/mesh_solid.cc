#include "clients/meshes/mesh_solid.h"

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "collision/geometry/mesh_closing.h"

namespace cwm::meshes {

MeshSolid DescribeSolid(const TriangleMesh& mesh) {
  if (IsWatertight(mesh)) return {.is_open = false, .text = "closed"};
  const std::optional<ClosedMesh> closed = Close(mesh);
  if (!closed) return {.is_open = true, .text = "open"};
  std::vector<std::string> mended;
  const auto add = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) mended.push_back(count == 1 ? one : absl::StrCat(count, many));
  };
  add(closed->repeated, "a repeated triangle left out", " repeated triangles left out");
  add(closed->split_edges, "an edge split at vertices on it", " edges split at vertices on them");
  return {.is_open = false, .text = absl::StrCat("closed (", absl::StrJoin(mended, ", "), ")")};
}

}  // namespace cwm::meshes
