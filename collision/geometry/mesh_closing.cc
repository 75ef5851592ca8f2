#include "collision/geometry/mesh_closing.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "collision/geometry/interruptible_sort.h"
#include "collision/geometry/mesh_holes.h"

namespace cwm {
namespace {

using Triangle = TriangleMesh::Triangle;

// chosen: a mesh with more open edges has holes, and a search among all pairs of them is slow.
constexpr std::size_t kMaxOpenEdges = 4096;
// chosen: as a share of the extent; coordinates in single precision are off by 6e-8 of themselves.
constexpr double kOnEdge = 1e-7;
// chosen: splitting an edge opens none, so that one round is enough unless triangles share several.
constexpr int kMaxRounds = 4;
// chosen: each query that comes near a mesh with holes looks at every hole.
constexpr std::size_t kMaxHoles = 64;
// chosen: the largest share of holes in the area of a mesh. Vessels and sheets, which are meant to
// be open, exceed it by far.
constexpr double kMaxHoleShare = 0.01;

// The triangle with its smallest index first, which keeps its winding.
Triangle Rotated(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

// Triangles by vertices at distinct positions, without those that collapse and those that repeat
// another. Sets the number of repeated ones. Void if `work` ended it.
std::vector<Triangle> Distinct(const TriangleMesh& mesh, const std::vector<std::uint32_t>& welded,
                               std::size_t& repeated, WorkCounter* work) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto& [a, b, c] = mesh.triangles[i];
      const Triangle t = Rotated({welded[a], welded[b], welded[c]});
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
  });
  if (HasEnded(work)) return {};
  InterruptibleSort(triangles, std::less<>(), work);
  if (HasEnded(work)) return {};
  const auto end = std::unique(triangles.begin(), triangles.end());
  repeated = static_cast<std::size_t>(triangles.end() - end);
  triangles.erase(end, triangles.end());
  return triangles;
}

// The edges that are not run through as often in the other direction, ordered. Void if `work` ended
// it; ends early with more than kMaxOpenEdges.
std::vector<MeshEdge> OpenEdges(const std::vector<Triangle>& triangles, WorkCounter* work) {
  // From the smaller to the larger index, and whether the triangle runs so.
  struct Side {
    MeshEdge edge;
    bool forward = true;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  ForEachBlock(triangles.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = triangles[i][k], to = triangles[i][(k + 1) % 3];
        sides.push_back({std::minmax(from, to), from < to});
      }
    }
  });
  if (HasEnded(work)) return {};
  InterruptibleSort(
      sides, [](const Side& a, const Side& b) { return a.edge < b.edge; }, work);
  if (HasEnded(work)) return {};
  std::vector<MeshEdge> open;
  for (std::size_t i = 0; i < sides.size() && open.size() <= kMaxOpenEdges;) {
    const MeshEdge edge = sides[i].edge;
    int surplus = 0;  // of the direction from the smaller to the larger index
    for (; i < sides.size() && sides[i].edge == edge; ++i) surplus += sides[i].forward ? 1 : -1;
    if (surplus > 0) open.push_back(edge);
    if (surplus < 0) open.emplace_back(edge.second, edge.first);
    if (MustEnd(work, 1)) return {};
  }
  std::ranges::sort(open);
  return open;
}

// Splits triangles at the vertices that lie on their open edges; the number of edges split.
class EdgeSplitter {
 public:
  EdgeSplitter(const std::vector<Vector3>& vertices, double tolerance_m)
      : vertices_(vertices), tolerance_m_(tolerance_m) {}

  std::size_t Split(const std::vector<MeshEdge>& open, std::vector<Triangle>& triangles,
                    WorkCounter* work) const {
    std::set<std::uint32_t> ends;
    for (const auto& [from, to] : open) ends.insert({from, to});
    std::size_t count = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (MustEnd(work, 1)) return count;
      for (std::size_t k = 0; k < 3; ++k) {
        const Triangle t = triangles[i];
        const MeshEdge edge{t[k], t[(k + 1) % 3]};
        if (!std::ranges::binary_search(open, edge)) continue;
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

double Area_m2(const TriangleMesh& mesh, WorkCounter* work) {
  double doubled_m2 = 0;
  ForEachBlock(mesh.triangles.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto& [a, b, c] = mesh.triangles[i];
      const Vector3& corner = mesh.vertices[a];
      doubled_m2 += (mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner).norm();
    }
  });
  return 0.5 * doubled_m2;
}

// Closes the holes of a mesh if they are few and small, and says what they are. False if they are
// not, or if `work` ended it; the mesh is void then.
bool CloseHoles(const std::vector<MeshEdge>& open, ClosedMesh& closed, MeshOpening& opening,
                WorkCounter* work) {
  if (open.size() > kMaxOpenEdges) return false;
  const auto loops = BoundaryLoops(open);
  if (!loops) return false;
  opening.holes = loops->size();
  const double area_m2 = Area_m2(closed.mesh, work);
  double of_holes_m2 = 0;
  for (const BoundaryLoop& loop : *loops) {
    const HoleFan fan = FanOf(loop, closed.mesh.vertices, work);
    if (HasEnded(work)) return false;
    closed.mesh.triangles.insert(closed.mesh.triangles.end(), fan.triangles.begin(),
                                 fan.triangles.end());
    closed.caps.push_back(fan.cap);
    of_holes_m2 += fan.area_m2;
    opening.largest_m = std::max(opening.largest_m, fan.cap.diameter_m);
  }
  opening.area_share = area_m2 > 0 ? of_holes_m2 / area_m2 : 1;
  return loops->size() <= kMaxHoles && opening.area_share <= kMaxHoleShare;
}

}  // namespace

MeshClosing TryClose(const TriangleMesh& mesh, WorkCounter* work) {
  MeshClosing result;
  const std::vector<std::uint32_t> welded = WeldedVertices(mesh.vertices, work);
  if (HasEnded(work)) return result;
  ClosedMesh closed;
  closed.mesh.vertices = mesh.vertices;
  std::vector<Triangle>& triangles = closed.mesh.triangles;
  triangles = Distinct(mesh, welded, closed.repeated, work);
  const EdgeSplitter splitter(mesh.vertices, kOnEdge * Extent_m(mesh.vertices));
  std::vector<MeshEdge> open = OpenEdges(triangles, work);
  for (int round = 0; round < kMaxRounds && !open.empty(); ++round) {
    if (open.size() > kMaxOpenEdges) break;
    const std::size_t split = splitter.Split(open, triangles, work);
    if (split == 0 || HasEnded(work)) break;
    closed.split_edges += split;
    open = OpenEdges(triangles, work);
  }
  result.opening.edges = open.size();
  const bool is_capped = open.empty() || CloseHoles(open, closed, result.opening, work);
  if (HasEnded(work) || !is_capped || !IsWatertight(closed.mesh, work)) return result;
  result.closed = std::move(closed);
  return result;
}

std::optional<ClosedMesh> Close(const TriangleMesh& mesh, WorkCounter* work) {
  return TryClose(mesh, work).closed;
}

std::optional<Mesh> SolidOf(std::shared_ptr<const TriangleMesh> mesh, WorkCounter* work) {
  const bool watertight = IsWatertight(*mesh, work);
  if (HasEnded(work)) return std::nullopt;
  if (watertight) return Mesh{.mesh = std::move(mesh), .watertight = true};
  std::optional<ClosedMesh> closed = Close(*mesh, work);
  if (HasEnded(work)) return std::nullopt;
  if (!closed) return Mesh{.mesh = std::move(mesh), .watertight = false};
  Mesh solid{.mesh = std::make_shared<const TriangleMesh>(std::move(closed->mesh)),
             .watertight = true};
  if (!closed->caps.empty()) {
    solid.caps = std::make_shared<const MeshCaps::element_type>(std::move(closed->caps));
  }
  return solid;
}

}  // namespace cwm
