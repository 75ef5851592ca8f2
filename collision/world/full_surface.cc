#include "collision/world/full_surface.h"

#include <algorithm>
#include <variant>

namespace cwm::collision {
namespace {

// Four times the deviation is half the segments: a quarter of the triangles of a ball.
constexpr double kCoarser = 4;
// Every round part of up to 100 m has kMinSegments by then: a sagitta is less than its radius.
constexpr double kCoarsestDeviation_m = 100;

// Meshes that are taken as they are, not to be copied.
const TriangleMesh* MeshIn(const Shape& shape) {
  if (const auto* convex = std::get_if<Convex>(&shape)) return convex->hull.get();
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return mesh->mesh.get();
  return nullptr;
}

// Those that no coarser deviation spares.
std::size_t GivenTriangles(const PreparedModel& model) {
  std::size_t count = 0;
  for (const PreparedPart& part : model.parts) {
    if (const TriangleMesh* mesh = MeshIn(part.shape)) count += mesh->triangles.size();
  }
  return count;
}

void Append(const TriangleMesh& mesh_P, const Pose& X_OP, TriangleMesh& all_O) {
  const auto first = static_cast<std::uint32_t>(all_O.vertices.size());
  for (const Vector3& p_P : mesh_P.vertices) all_O.vertices.push_back(X_OP * p_P);
  for (const auto& [a, b, c] : mesh_P.triangles) {
    all_O.triangles.push_back({first + a, first + b, first + c});
  }
}

// Nothing when the parts have more triangles.
std::optional<FullSurface> Joined(const PreparedModel& model, double deviation_m,
                                  std::size_t max_triangles) {
  FullSurface surface;
  TriangleMesh& all_O = surface.mesh_O;
  for (const PreparedPart& part : model.parts) {
    TriangleMesh made;
    const TriangleMesh* mesh = MeshIn(part.shape);
    if (mesh == nullptr) mesh = &(made = Tessellate(part.shape, deviation_m));
    if (all_O.triangles.size() + mesh->triangles.size() > max_triangles) return std::nullopt;
    Append(*mesh, part.X_OP, all_O);
    surface.max_deviation_m =
        std::max(surface.max_deviation_m, DeviationBound_m(part.shape, deviation_m));
  }
  return surface;
}

}  // namespace

bool IsBounded(const PreparedModel& model) {
  return std::none_of(model.parts.begin(), model.parts.end(), [](const PreparedPart& part) {
    return KindOf(part.shape) == ShapeKind::kHalfSpace;
  });
}

std::optional<FullSurface> FullSurfaceOf(const PreparedModel& model, std::size_t max_triangles) {
  if (GivenTriangles(model) > max_triangles) return std::nullopt;
  double deviation_m = kDefaultDeviation_m;
  std::optional<FullSurface> surface = Joined(model, deviation_m, max_triangles);
  while (!surface && deviation_m < kCoarsestDeviation_m) {
    deviation_m *= kCoarser;
    surface = Joined(model, deviation_m, max_triangles);
  }
  return surface;
}

}  // namespace cwm::collision
