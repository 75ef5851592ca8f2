#include "collision/engines/closed_mesh.h"

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "collision/geometry/winding.h"

namespace cwm::collision {
namespace {

// Rays in no particular direction: tried in turn until one passes clear of all edges.
const std::array<Vector3, 3> kDirections = {Vector3(0.7548776662, 0.5698402910, 0.3247179572),
                                            Vector3(-0.2451223338, 0.6180339887, 0.7469795250),
                                            Vector3(0.3819660113, -0.8087438212, 0.4476417621)};

// A crossing this near (as a share of the triangle) to an edge or seen this edge-on is not trusted.
constexpr double kClearance = 1e-9;

// How a ray passes a triangle: +1 leaving through its front, -1 entering through it, 0 missing it,
// nothing where rounding could change the answer. Moeller and Trumbore 1997.
std::optional<int> Crossing(const Vector3& o, const Vector3& d, const Vector3& a, const Vector3& b,
                            const Vector3& c) {
  const Vector3 ab = b - a;
  const Vector3 ac = c - a;
  const Vector3 across = d.cross(ac);
  const double determinant = ab.dot(across);
  if (std::abs(determinant) <= kClearance * ab.norm() * ac.norm()) return std::nullopt;
  const Vector3 ao = o - a;
  const Vector3 along = ao.cross(ab);
  const double u = ao.dot(across) / determinant;
  const double v = d.dot(along) / determinant;
  if (u < -kClearance || v < -kClearance || u + v > 1 + kClearance) return 0;
  if (u < kClearance || v < kClearance || u + v > 1 - kClearance) return std::nullopt;
  if (ac.dot(along) / determinant < 0) return 0;  // behind the origin
  // The determinant is -d . n: negative where the ray leaves through the front.
  return determinant < 0 ? 1 : -1;
}

}  // namespace

ClosedMesh::ClosedMesh(std::shared_ptr<const TriangleMesh> mesh) : mesh_(std::move(mesh)) {
  std::vector<Aabb> boxes;
  boxes.reserve(mesh_->triangles.size());
  for (const auto& t : mesh_->triangles) {
    Aabb box(mesh_->vertices[t[0]]);
    box.extend(mesh_->vertices[t[1]]);
    box.extend(mesh_->vertices[t[2]]);
    boxes.push_back(box);
  }
  triangles_ = BoundsTree(boxes);
}

bool ClosedMesh::Contains(const Vector3& p) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Vector3& direction : kDirections) {
    int winding = 0;
    bool clear = true;
    triangles_.ForEachOnRay(p, direction, kInfinity, [&](std::uint32_t i, double) {
      const auto& t = mesh_->triangles[i];
      const std::optional<int> crossing = Crossing(p, direction, mesh_->vertices[t[0]],
                                                   mesh_->vertices[t[1]], mesh_->vertices[t[2]]);
      clear = crossing.has_value();
      winding += crossing.value_or(0);
      return clear ? kInfinity : -1;
    });
    if (clear) return winding > 0;
  }
  return WindingNumber(*mesh_, p) > 0.5;
}

std::vector<Vector3> ComponentPoints(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    const std::uint32_t a = root(t[0]);
    parent[root(t[1])] = a;
    parent[root(t[2])] = a;
  }
  std::vector<Vector3> points;
  std::vector<bool> seen(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) {
    const std::uint32_t component = root(t[0]);
    if (seen[component]) continue;
    seen[component] = true;
    points.push_back(mesh.vertices[t[0]]);
  }
  return points;
}

}  // namespace cwm::collision
