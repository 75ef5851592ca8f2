#include "collision/world/full_surface.h"

#include <algorithm>
#include <variant>

namespace cwm::collision {
namespace {

// derived: four times the deviation halves the number of segments, and leaves a quarter of a
// sphere's triangles.
constexpr double kCoarseningFactor = 4;
// derived: at this deviation every round part of up to 100 m has kMinSegments, because a sagitta is
// smaller than its radius.
constexpr double kMaxDeviation_m = 100;

// The mesh of a shape that is used as it is, not copied; nullptr for other shapes.
const TriangleMesh* MeshIn(const Shape& shape) {
  if (const auto* convex = std::get_if<Convex>(&shape)) return convex->hull.get();
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return mesh->mesh.get();
  return nullptr;
}

// The number of triangles in given meshes, which a coarser deviation does not reduce.
std::size_t GivenTriangles(const PreparedModel& model) {
  std::size_t count = 0;
  for (const PreparedPart& part : model.parts) {
    if (const TriangleMesh* mesh = MeshIn(part.shape)) count += mesh->triangles.size();
  }
  return count;
}

void Append(const TriangleMesh& mesh_P, const Pose& X_OP, TriangleMesh& all_O, WorkCounter* work) {
  const auto offset = static_cast<std::uint32_t>(all_O.vertices.size());
  ForEachBlock(mesh_P.vertices.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) all_O.vertices.push_back(X_OP * mesh_P.vertices[i]);
  });
  ForEachBlock(mesh_P.triangles.size(), work, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const auto& [a, b, c] = mesh_P.triangles[i];
      all_O.triangles.push_back({offset + a, offset + b, offset + c});
    }
  });
}

// The parts as one mesh; empty if they have more triangles than allowed.
std::optional<FullSurface> Joined(const PreparedModel& model, double deviation_m,
                                  std::size_t max_triangles, WorkCounter* work) {
  FullSurface surface;
  TriangleMesh& all_O = surface.mesh_O;
  for (const PreparedPart& part : model.parts) {
    if (HasEnded(work)) return surface;
    TriangleMesh made;
    const TriangleMesh* mesh = MeshIn(part.shape);
    if (mesh == nullptr) mesh = &(made = Tessellate(part.shape, deviation_m));
    if (all_O.triangles.size() + mesh->triangles.size() > max_triangles) return std::nullopt;
    Append(*mesh, part.X_OP, all_O, work);
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

std::optional<FullSurface> FullSurfaceOf(const PreparedModel& model, std::size_t max_triangles,
                                         WorkCounter* work) {
  if (GivenTriangles(model) > max_triangles) return std::nullopt;
  double deviation_m = kDefaultDeviation_m;
  std::optional<FullSurface> surface = Joined(model, deviation_m, max_triangles, work);
  while (!surface && deviation_m < kMaxDeviation_m) {
    deviation_m *= kCoarseningFactor;
    surface = Joined(model, deviation_m, max_triangles, work);
  }
  return surface;
}

}  // namespace cwm::collision
