#include "perception/model/full_surface.h"

#include "collision/geometry/tessellate.h"

namespace cwm::perception {
namespace {

void Append(const TriangleMesh& part, const Pose& X_OP, TriangleMesh& whole) {
  const auto first = static_cast<std::uint32_t>(whole.vertices.size());
  for (const Vector3& vertex : part.vertices) whole.vertices.push_back(X_OP * vertex);
  for (TriangleMesh::Triangle triangle : part.triangles) {
    for (std::uint32_t& vertex : triangle) vertex += first;
    whole.triangles.push_back(triangle);
  }
}

}  // namespace

TriangleMesh FullSurface(const HybridModel& model, double max_deviation_m) {
  TriangleMesh whole;
  for (const ShapePart& part : model.shapes) {
    Append(Tessellate(part.shape, max_deviation_m), part.X_OS, whole);
  }
  for (const SurfacePart& surface : model.surfaces) {
    if (surface.surface.mesh) Append(*surface.surface.mesh, Pose::Identity(), whole);
  }
  for (const Handle& handle : model.handles) {
    if (handle.surface.mesh) Append(*handle.surface.mesh, Pose::Identity(), whole);
  }
  return whole;
}

}  // namespace cwm::perception
