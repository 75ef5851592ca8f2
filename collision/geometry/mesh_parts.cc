#include "collision/geometry/mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/winding.h"

namespace cwm {
namespace {

// Parts are compared with each other: a mesh of more of them is turned as a whole.
constexpr std::size_t kMostParts = 1'000;

// Of a mesh, what hangs together.
struct Part {
  TriangleMesh surface;
  Aabb bounds;

  const Vector3& point() const { return surface.vertices.front(); }
  bool Encloses(const Vector3& p) const {
    return bounds.contains(p) && std::abs(WindingNumber(surface, p)) > 0.5;
  }
};

std::vector<Part> PartsOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& components) {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i] == parts.size()) parts.emplace_back();
    auto& [surface, bounds] = parts[components[i]];
    const auto first = static_cast<std::uint32_t>(surface.vertices.size());
    surface.triangles.push_back({first, first + 1, first + 2});
    for (const std::uint32_t v : mesh.triangles[i]) {
      surface.vertices.push_back(mesh.vertices[v]);
      bounds.extend(mesh.vertices[v]);
    }
  }
  return parts;
}

// Tells most meshes by one pass over their triangles.
bool AnyInward(const TriangleMesh& mesh, const std::vector<std::uint32_t>& components) {
  const Vector3 origin = mesh.vertices.empty() ? Vector3::Zero() : mesh.vertices.front();
  std::vector<double> volumes;  // six times, of the parts
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i] == volumes.size()) volumes.push_back(0);
    const auto& [a, b, c] = mesh.triangles[i];
    volumes[components[i]] +=
        (mesh.vertices[a] - origin).cross(mesh.vertices[b] - origin).dot(mesh.vertices[c] - origin);
  }
  return std::ranges::any_of(volumes, [](double volume) { return volume < 0; });
}

}  // namespace

TriangleMesh WoundOutward(TriangleMesh mesh) {
  const std::vector<std::uint32_t> components = Components(mesh);
  if (!AnyInward(mesh, components)) return mesh;
  std::vector<Part> parts = PartsOf(mesh, components);
  if (parts.size() > kMostParts) {
    parts = {{.surface = mesh, .bounds = {}}};
  }
  const auto is_in = [&parts](std::size_t inner, std::size_t outer) {
    return inner != outer && parts[outer].Encloses(parts[inner].point());
  };
  std::vector<bool> turns(parts.size(), false);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (SignedVolume_m3(parts[i].surface) >= 0) continue;
    bool is_free = true;
    for (std::size_t k = 0; k < parts.size() && is_free; ++k) is_free = !is_in(i, k);
    if (!is_free) continue;
    for (std::size_t k = 0; k < parts.size(); ++k) turns[k] = turns[k] || k == i || is_in(k, i);
  }
  for (std::size_t i = 0; i < components.size(); ++i) {
    TriangleMesh::Triangle& triangle = mesh.triangles[i];
    if (turns[parts.size() == 1 ? 0 : components[i]]) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

}  // namespace cwm
