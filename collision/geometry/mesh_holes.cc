#include "collision/geometry/mesh_holes.h"

#include <algorithm>
#include <map>

namespace cwm {
namespace {

// chosen: as a share of the diameter, some thousands of roundings. The capsule then holds the
// vertices although its axis and their distances are rounded.
constexpr double kRounding = 1e-12;

double Area_m2(const std::vector<Vector3>& vertices, const TriangleMesh::Triangle& t) {
  const Vector3& corner = vertices[t[0]];
  return 0.5 * (vertices[t[1]] - corner).cross(vertices[t[2]] - corner).norm();
}

// The two vertices that are farthest apart.
std::array<Vector3, 2> LongestDiagonal(const std::vector<Vector3>& points, WorkCounter* work) {
  std::array<Vector3, 2> longest = {points.front(), points.front()};
  double squared_m2 = 0;
  for (std::size_t i = 0; i < points.size() && !MustEnd(work, 1 + i / 8); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double of_pair_m2 = (points[i] - points[k]).squaredNorm();
      if (of_pair_m2 <= squared_m2) continue;
      squared_m2 = of_pair_m2;
      longest = {points[k], points[i]};
    }
  }
  return longest;
}

// A capsule around the points, along their longest diagonal.
MeshCap CapsuleAround(const std::vector<Vector3>& points, WorkCounter* work) {
  const std::array<Vector3, 2> diagonal = LongestDiagonal(points, work);
  const Vector3 along = (diagonal[1] - diagonal[0]).normalized();
  const auto across = [&](const Vector3& p) -> Vector3 {
    const Vector3 from = p - diagonal[0];
    return from - from.dot(along) * along;
  };
  // Seen along the diagonal, the axis is in the middle of the points, not at its ends.
  const Vector3 side = along.unitOrthogonal(), up = along.cross(side);
  Eigen::AlignedBox2d seen;
  for (const Vector3& p : points) seen.extend(Vector2(across(p).dot(side), across(p).dot(up)));
  const Vector3 shift = seen.center().x() * side + seen.center().y() * up;
  MeshCap cap{.axis = {diagonal[0] + shift, diagonal[1] + shift},
              .radius_m = 0,
              .diameter_m = (diagonal[1] - diagonal[0]).norm()};
  for (const Vector3& p : points) cap.radius_m = std::max(cap.radius_m, (across(p) - shift).norm());
  cap.radius_m += kRounding * cap.diameter_m;
  return cap;
}

}  // namespace

std::optional<std::vector<BoundaryLoop>> BoundaryLoops(std::span<const MeshEdge> open_edges) {
  const std::map<std::uint32_t, std::uint32_t> next(open_edges.begin(), open_edges.end());
  if (next.size() != open_edges.size()) return std::nullopt;
  std::map<std::uint32_t, bool> is_done;
  std::vector<BoundaryLoop> loops;
  for (const auto& [first, second] : next) {
    if (is_done[first]) continue;
    BoundaryLoop loop;
    std::uint32_t at = first;
    do {
      if (!next.contains(at) || is_done[at]) return std::nullopt;
      is_done[at] = true;
      loop.push_back(at);
      at = next.at(at);
    } while (at != first);
    if (loop.size() < 3) return std::nullopt;
    loops.push_back(std::move(loop));
  }
  return loops;
}

HoleFan FanOf(const BoundaryLoop& loop, std::vector<Vector3>& vertices, WorkCounter* work) {
  std::vector<Vector3> points;
  points.reserve(loop.size());
  Vector3 sum = Vector3::Zero();
  for (const std::uint32_t v : loop) {
    points.push_back(vertices[v]);
    sum += vertices[v];
  }
  HoleFan fan{.cap = CapsuleAround(points, work), .area_m2 = 0, .triangles = {}};
  if (loop.size() == 3) {
    fan.triangles = {{loop[2], loop[1], loop[0]}};
  } else {
    const auto centre = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(sum / static_cast<double>(loop.size()));
    for (std::size_t k = 0; k < loop.size(); ++k) {
      fan.triangles.push_back({loop[(k + 1) % loop.size()], loop[k], centre});
    }
  }
  for (const TriangleMesh::Triangle& t : fan.triangles) fan.area_m2 += Area_m2(vertices, t);
  return fan;
}

}  // namespace cwm
