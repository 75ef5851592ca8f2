#include "collision/geometry/mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "collision/geometry/aabb.h"
#include "collision/geometry/winding.h"

namespace cwm {
namespace {

// chosen: bounds the comparison of every component with every other; a mesh of more components is
// turned as a whole.
constexpr std::size_t kMaxParts = 1'000;

// One connected component of a mesh.
struct Part {
  TriangleMesh surface;
  Aabb bounds;

  const Vector3& point() const { return surface.vertices.front(); }
  bool Contains(const Vector3& p, WorkCounter* work) const {
    if (!bounds.contains(p)) return false;
    constexpr std::size_t kStepsPerAngle = 2;
    double angle_sr = 0;
    const auto add = [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const auto& [a, b, c] = surface.triangles[i];
        angle_sr += SolidAngle_sr(surface.vertices[a] - p, surface.vertices[b] - p,
                                  surface.vertices[c] - p);
      }
    };
    return ForEachBlock(surface.triangles.size(), work, add, kStepsPerAngle) &&
           std::abs(angle_sr) > 2 * std::numbers::pi;
  }
};

std::vector<Part> PartsOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& components,
                          WorkCounter* work) {
  std::vector<std::size_t> counts;  // triangles per part, to reserve memory before the parts grow
  ForEachBlock(components.size(), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (components[i] == counts.size()) counts.push_back(0);
      ++counts[components[i]];
    }
  });
  std::vector<Part> parts;
  parts.reserve(counts.size());
  ForEachBlock(components.size(), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (components[i] == parts.size()) {
        parts.emplace_back();
        parts.back().surface.vertices.reserve(3 * counts[components[i]]);
        parts.back().surface.triangles.reserve(counts[components[i]]);
      }
      auto& [surface, bounds] = parts[components[i]];
      const auto first = static_cast<std::uint32_t>(surface.vertices.size());
      surface.triangles.push_back({first, first + 1, first + 2});
      for (const std::uint32_t v : mesh.triangles[i]) {
        surface.vertices.push_back(mesh.vertices[v]);
        bounds.extend(mesh.vertices[v]);
      }
    }
  });
  return parts;
}

// Six times the signed volume of each part. One pass over the triangles, which suffices for the
// many meshes without a negative part.
std::vector<double> VolumesOf(const TriangleMesh& mesh,
                              const std::vector<std::uint32_t>& components, WorkCounter* work) {
  const Vector3 origin = mesh.vertices.empty() ? Vector3::Zero() : mesh.vertices.front();
  std::vector<double> volumes;
  ForEachBlock(components.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (components[i] == volumes.size()) volumes.push_back(0);
      const auto& [a, b, c] = mesh.triangles[i];
      volumes[components[i]] += (mesh.vertices[a] - origin)
                                    .cross(mesh.vertices[b] - origin)
                                    .dot(mesh.vertices[c] - origin);
    }
  });
  return volumes;
}

}  // namespace

std::vector<bool> TrianglesWoundInward(const TriangleMesh& mesh,
                                       const std::vector<std::uint32_t>& components,
                                       WorkCounter* work) {
  const std::vector<double> volumes = VolumesOf(mesh, components, work);
  if (std::ranges::none_of(volumes, [](double volume) { return volume < 0; })) return {};
  if (HasEnded(work)) return {};
  if (volumes.size() == 1 || volumes.size() > kMaxParts) {
    return std::vector<bool>(SignedVolume_m3(mesh, work) < 0 ? components.size() : 0, true);
  }
  const std::vector<Part> parts = PartsOf(mesh, components, work);
  if (HasEnded(work)) return {};
  const auto is_in = [&](std::size_t inner, std::size_t outer) {
    return inner != outer && parts[outer].Contains(parts[inner].point(), work);
  };
  std::vector<bool> turns(parts.size(), false);
  for (std::size_t i = 0; i < parts.size() && !HasEnded(work); ++i) {
    if (SignedVolume_m3(parts[i].surface, work) >= 0) continue;
    bool is_free = true;
    for (std::size_t k = 0; k < parts.size() && is_free; ++k) is_free = !is_in(i, k);
    if (!is_free) continue;
    for (std::size_t k = 0; k < parts.size(); ++k) turns[k] = turns[k] || k == i || is_in(k, i);
  }
  std::vector<bool> is_inward;
  is_inward.reserve(components.size());
  ForEachBlock(components.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) is_inward.push_back(turns[components[i]]);
  });
  return is_inward;
}

}  // namespace cwm
