#include "collision/geometry/triangle_mesh.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "collision/geometry/interruptible_sort.h"

namespace cwm {
namespace {

// A vector of equal values, filled in pieces that `work` can end: touching memory for the first
// time takes a tenth of a nanosecond per byte.
std::vector<std::uint32_t> Filled(std::size_t count, std::uint32_t value, WorkCounter* work) {
  std::vector<std::uint32_t> filled;
  filled.reserve(count);
  ForEachBlock(count, work, [&](std::size_t, std::size_t last) { filled.resize(last, value); });
  return filled;
}

// An edge as a key: its ends, the smaller index first, and in the lowest bit the direction in which
// a triangle runs through it. Indices are below 2^31, since that many vertices take 48 GB.
std::uint64_t EdgeOf(std::uint64_t from, std::uint64_t to) {
  return from < to ? from << 33 | to << 1 : to << 33 | from << 1 | 1;
}

// True if each edge occurs exactly twice, once in each direction.
bool IsEveryEdgePaired(const std::vector<TriangleMesh::Triangle>& triangles, WorkCounter* work) {
  if (triangles.empty()) return false;
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * triangles.size());
  bool is_flat = false;
  const bool is_listed =
      ForEachBlock(triangles.size(), work, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last && !is_flat; ++k) {
          const TriangleMesh::Triangle& t = triangles[k];
          for (std::size_t i = 0; i < 3; ++i) {
            is_flat = is_flat || t[i] == t[(i + 1) % 3];
            edges.push_back(EdgeOf(t[i], t[(i + 1) % 3]));
          }
        }
      });
  if (!is_listed || is_flat || edges.size() % 2 != 0) return false;
  InterruptibleSort(edges, std::less<>(), work);
  if (HasEnded(work)) return false;
  bool is_paired = true;
  const bool is_seen =
      ForEachBlock(edges.size() / 2, work, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last && is_paired; ++k) {
          // Both directions of one edge are neighbours in the order; a third copy of an edge would
          // misalign the pairs.
          is_paired = edges[2 * k] % 2 == 0 && edges[2 * k + 1] == edges[2 * k] + 1;
        }
      });
  return is_seen && is_paired;
}

}  // namespace

std::vector<std::uint32_t> WeldedVertices(const std::vector<Vector3>& vertices, WorkCounter* work) {
  std::vector<std::uint32_t> order;
  order.reserve(vertices.size());
  const bool is_filled =
      ForEachBlock(vertices.size(), work, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) order.push_back(static_cast<std::uint32_t>(i));
      });
  if (!is_filled) return {};
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Vector3 &p = vertices[a], &q = vertices[b];
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  };
  InterruptibleSort(order, before, work);
  if (HasEnded(work)) return {};
  std::vector<std::uint32_t> welded = Filled(vertices.size(), 0, work);
  if (HasEnded(work)) return {};
  const bool is_welded = ForEachBlock(order.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const bool is_same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
      welded[order[i]] = is_same ? welded[order[i - 1]] : order[i];
    }
  });
  if (!is_welded) return {};
  return welded;
}

bool IsWatertightByIndex(const TriangleMesh& mesh, WorkCounter* work) {
  return IsEveryEdgePaired(mesh.triangles, work);
}

// Indices are tested first: solids that touch along an edge are closed although four triangles
// share the positions of that edge.
bool IsWatertight(const TriangleMesh& mesh, WorkCounter* work) {
  if (IsWatertightByIndex(mesh, work)) return true;
  const std::vector<std::uint32_t> welded = WeldedVertices(mesh.vertices, work);
  if (HasEnded(work)) return false;
  std::vector<TriangleMesh::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  const auto weld = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const TriangleMesh::Triangle& t = mesh.triangles[i];
      const std::uint32_t a = welded[t[0]], b = welded[t[1]], c = welded[t[2]];
      // A triangle that welding has collapsed is left out: its remaining two edges cancel each
      // other.
      if (a == b || b == c || c == a) continue;
      triangles.push_back({a, b, c});
    }
  };
  return ForEachBlock(mesh.triangles.size(), work, weld) && IsEveryEdgePaired(triangles, work);
}

std::vector<std::uint32_t> ConnectedComponents(const TriangleMesh& mesh, WorkCounter* work) {
  std::vector<std::uint32_t> parent = WeldedVertices(mesh.vertices, work);
  if (HasEnded(work)) return {};
  const auto root = [&parent](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  const bool is_joined =
      ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
          const TriangleMesh::Triangle& t = mesh.triangles[i];
          const std::uint32_t a = root(t[0]);
          parent[root(t[1])] = a;
          parent[root(t[2])] = a;
        }
      });
  if (!is_joined) return {};
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number = Filled(mesh.vertices.size(), kNone, work);
  if (HasEnded(work)) return {};
  std::vector<std::uint32_t> components;
  components.reserve(mesh.triangles.size());
  std::uint32_t count = 0;
  const bool is_counted =
      ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
          std::uint32_t& component = number[root(mesh.triangles[i][0])];
          if (component == kNone) component = count++;
          components.push_back(component);
        }
      });
  if (!is_counted) return {};
  return components;
}

std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh,
                                     const std::vector<std::uint32_t>& components) {
  std::vector<Vector3> points;
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i] == points.size()) points.push_back(mesh.vertices[mesh.triangles[i][0]]);
  }
  return points;
}

std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh, WorkCounter* work) {
  return ComponentPoints(mesh, ConnectedComponents(mesh, work));
}

double SignedVolume_m3(const TriangleMesh& mesh, WorkCounter* work) {
  if (mesh.vertices.empty()) return 0;
  const Vector3 origin = mesh.vertices.front();  // near the mesh, against cancellation
  double six_volumes = 0;
  ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const TriangleMesh::Triangle& t = mesh.triangles[i];
      const Vector3 a = mesh.vertices[t[0]] - origin;
      const Vector3 b = mesh.vertices[t[1]] - origin;
      const Vector3 c = mesh.vertices[t[2]] - origin;
      six_volumes += a.dot(b.cross(c));
    }
  });
  return six_volumes / 6.0;
}

}  // namespace cwm
