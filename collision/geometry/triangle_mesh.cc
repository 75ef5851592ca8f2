#include "collision/geometry/triangle_mesh.h"

#include <algorithm>

namespace cwm {

bool IsWatertight(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return false;
  std::vector<std::uint64_t> forward, backward;
  forward.reserve(3 * mesh.triangles.size());
  backward.reserve(3 * mesh.triangles.size());
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t from = t[i], to = t[(i + 1) % 3];
      if (from == to) return false;
      forward.push_back(from << 32 | to);
      backward.push_back(to << 32 | from);
    }
  }
  std::sort(forward.begin(), forward.end());
  if (std::adjacent_find(forward.begin(), forward.end()) != forward.end()) return false;
  std::sort(backward.begin(), backward.end());
  return forward == backward;
}

double SignedVolume_m3(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Vector3 origin = mesh.vertices.front();  // near the mesh, against cancellation
  double six_volumes = 0;
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]] - origin;
    const Vector3 b = mesh.vertices[t[1]] - origin;
    const Vector3 c = mesh.vertices[t[2]] - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6.0;
}

}  // namespace cwm
