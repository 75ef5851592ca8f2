#include "collision/geometry/mesh_closing.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace cwm {
namespace {

using Triangle = TriangleMesh::Triangle;
using MeshEdge = std::pair<std::uint32_t, std::uint32_t>;  // in the direction of a triangle

// chosen: a mesh with more open edges has holes, and a search among all pairs of them is slow.
constexpr std::size_t kMaxOpenEdges = 4096;
// chosen: as a share of the extent; coordinates in single precision are off by 6e-8 of themselves.
constexpr double kOnEdge = 1e-7;
// chosen: splitting an edge opens none, so that one round is enough unless triangles share several.
constexpr int kMaxRounds = 4;

// The triangle with its smallest index first, which keeps its winding.
Triangle Rotated(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

// Triangles by vertices at distinct positions, without those that collapse and those that repeat
// another. Sets the number of repeated ones.
std::vector<Triangle> Distinct(const TriangleMesh& mesh, const std::vector<std::uint32_t>& welded,
                               std::size_t& repeated) {
  std::vector<Triangle> triangles;
  std::set<Triangle> known;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Triangle t = Rotated({welded[i], welded[j], welded[k]});
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    if (known.insert(t).second) {
      triangles.push_back(t);
    } else {
      ++repeated;
    }
  }
  return triangles;
}

// The edges that are not run through as often in the other direction.
std::set<MeshEdge> OpenEdges(const std::vector<Triangle>& triangles) {
  std::map<MeshEdge, int> surplus;  // of the direction from the smaller to the larger index
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t[k], to = t[(k + 1) % 3];
      surplus[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  std::set<MeshEdge> open;
  for (const auto& [edge, count] : surplus) {
    if (count > 0) open.insert(edge);
    if (count < 0) open.insert({edge.second, edge.first});
  }
  return open;
}

// Splits triangles at the vertices that lie on their open edges; the number of edges split.
class EdgeSplitter {
 public:
  EdgeSplitter(const std::vector<Vector3>& vertices, double tolerance_m)
      : vertices_(vertices), tolerance_m_(tolerance_m) {}

  std::size_t Split(const std::set<MeshEdge>& open, std::vector<Triangle>& triangles,
                    WorkCounter* work) const {
    std::set<std::uint32_t> ends;
    for (const auto& [from, to] : open) ends.insert({from, to});
    std::size_t count = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Triangle t = triangles[i];
        const MeshEdge edge{t[k], t[(k + 1) % 3]};
        if (!open.contains(edge)) continue;
        if (MustEnd(work, ends.size())) return count;
        const std::vector<std::uint32_t> on_edge = VerticesOn(edge, ends);
        if (on_edge.empty()) continue;
        ++count;
        // A fan from the opposite corner; the first piece replaces the triangle.
        const std::uint32_t opposite = t[(k + 2) % 3];
        std::uint32_t from = edge.first;
        bool is_first = true;
        for (const std::uint32_t to : on_edge) {
          const Triangle piece = {from, to, opposite};
          if (is_first) triangles[i] = piece;
          if (!is_first) triangles.push_back(piece);
          is_first = false;
          from = to;
        }
        triangles.push_back({from, edge.second, opposite});
        break;  // its other edges are those of pieces now, which a further round sees
      }
    }
    return count;
  }

 private:
  // The vertices inside the edge, from its first end on.
  std::vector<std::uint32_t> VerticesOn(const MeshEdge& edge,
                                        const std::set<std::uint32_t>& candidates) const {
    const Vector3 &from = vertices_[edge.first], &to = vertices_[edge.second];
    const Vector3 along = to - from;
    std::vector<std::pair<double, std::uint32_t>> found;
    for (const std::uint32_t v : candidates) {
      const double share = (vertices_[v] - from).dot(along) / along.squaredNorm();
      const double near_end_m = std::min(share, 1 - share) * along.norm();
      if (v == edge.first || v == edge.second || !(near_end_m > tolerance_m_)) continue;
      if ((from + share * along - vertices_[v]).norm() <= tolerance_m_) found.push_back({share, v});
    }
    std::ranges::sort(found);
    std::vector<std::uint32_t> ordered;
    for (const auto& [share, v] : found) ordered.push_back(v);
    return ordered;
  }

  const std::vector<Vector3>& vertices_;
  const double tolerance_m_;
};

double Extent_m(const std::vector<Vector3>& vertices) {
  Eigen::AlignedBox3d bounds;
  for (const Vector3& vertex : vertices) bounds.extend(vertex);
  return bounds.isEmpty() ? 0 : bounds.sizes().norm();
}

}  // namespace

std::optional<ClosedMesh> Close(const TriangleMesh& mesh, WorkCounter* work) {
  const std::vector<std::uint32_t> welded = WeldedVertices(mesh.vertices, work);
  if (HasEnded(work)) return std::nullopt;
  ClosedMesh closed;
  std::vector<Triangle> triangles = Distinct(mesh, welded, closed.repeated);
  const EdgeSplitter splitter(mesh.vertices, kOnEdge * Extent_m(mesh.vertices));
  std::set<MeshEdge> open = OpenEdges(triangles);
  for (int round = 0; round < kMaxRounds && !open.empty(); ++round) {
    if (open.size() > kMaxOpenEdges) return std::nullopt;
    const std::size_t split = splitter.Split(open, triangles, work);
    if (split == 0 || HasEnded(work)) return std::nullopt;
    closed.split_edges += split;
    open = OpenEdges(triangles);
  }
  closed.mesh = {.vertices = mesh.vertices, .triangles = std::move(triangles)};
  if (!open.empty() || !IsWatertight(closed.mesh, work)) return std::nullopt;
  return closed;
}

}  // namespace cwm
