#include "collision/geometry/triangle_mesh.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace cwm {
namespace {

// For each vertex the index of one at the same place, the same one for all of them.
std::vector<std::uint32_t> Welded(const std::vector<Vector3>& vertices) {
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Vector3 &p = vertices[a], &q = vertices[b];
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  };
  std::sort(order.begin(), order.end(), before);
  std::vector<std::uint32_t> welded(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    welded[order[i]] = is_same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

// Whether each edge of the triangles, of one way, has one of the other way.
bool PairsEdges(const std::vector<TriangleMesh::Triangle>& triangles) {
  if (triangles.empty()) return false;
  std::vector<std::uint64_t> forward, backward;
  forward.reserve(3 * triangles.size());
  backward.reserve(3 * triangles.size());
  for (const TriangleMesh::Triangle& t : triangles) {
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

}  // namespace

bool SharesEdges(const TriangleMesh& mesh) { return PairsEdges(mesh.triangles); }

// By indices first: solids that touch along an edge share its places, and are closed all the same.
bool IsWatertight(const TriangleMesh& mesh) {
  if (SharesEdges(mesh)) return true;
  const std::vector<std::uint32_t> welded = Welded(mesh.vertices);
  std::vector<TriangleMesh::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const std::uint32_t a = welded[t[0]], b = welded[t[1]], c = welded[t[2]];
    // Without an area: the edges that it has left are each other's.
    if (a == b || b == c || c == a) continue;
    triangles.push_back({a, b, c});
  }
  return PairsEdges(triangles);
}

std::vector<std::uint32_t> Components(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent = Welded(mesh.vertices);
  const auto root = [&parent](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const std::uint32_t a = root(t[0]);
    parent[root(t[1])] = a;
    parent[root(t[2])] = a;
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> components;
  components.reserve(mesh.triangles.size());
  std::uint32_t count = 0;
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    std::uint32_t& component = number[root(t[0])];
    if (component == kNone) component = count++;
    components.push_back(component);
  }
  return components;
}

std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> components = Components(mesh);
  std::vector<Vector3> points;
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i] == points.size()) points.push_back(mesh.vertices[mesh.triangles[i][0]]);
  }
  return points;
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
