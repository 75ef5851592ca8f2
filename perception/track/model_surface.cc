#include "perception/track/model_surface.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/tessellate.h"
#include "collision/geometry/triangle.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// Takes one sample for each full `area_m2` that accumulates over the triangles.
class Sampler {
 public:
  Sampler(double area_m2, std::vector<SurfaceSample>& samples)
      : area_m2_(area_m2), samples_(samples) {}

  // Small triangles are sampled at their centre, large ones at the centres of equal divisions.
  void Add(const Vector3& a, const Vector3& b, const Vector3& c, bool two_sided, int part) {
    const double triangle_m2 = 0.5 * (b - a).cross(c - a).norm();
    const int divisions =
        std::clamp(static_cast<int>(std::ceil(std::sqrt(triangle_m2 / area_m2_))), 1, 100);
    const Vector3 normal = TriangleNormal(a, b, c);
    const auto offer = [&](double i, double j) {
      waiting_m2_ += triangle_m2 / (divisions * divisions);
      if (waiting_m2_ < area_m2_) return;
      waiting_m2_ -= area_m2_;
      const Vector3 p = a + (i * (b - a) + j * (c - a)) / divisions;
      samples_.push_back({.p_O = p, .normal_O = normal, .two_sided = two_sided, .part = part});
    };
    for (int i = 0; i < divisions; ++i) {
      for (int j = 0; i + j < divisions; ++j) {
        offer(i + 1.0 / 3, j + 1.0 / 3);
        if (i + j + 1 < divisions) offer(i + 2.0 / 3, j + 2.0 / 3);
      }
    }
  }

 private:
  double area_m2_;
  double waiting_m2_ = 0;
  std::vector<SurfaceSample>& samples_;
};

double Area_m2(const TriangleMesh& mesh, const Pose& X_OS) {
  double twice_m2 = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3 ab = X_OS.linear() * (mesh.vertices[b] - mesh.vertices[a]);
    const Vector3 ac = X_OS.linear() * (mesh.vertices[c] - mesh.vertices[a]);
    twice_m2 += ab.cross(ac).norm();
  }
  return 0.5 * twice_m2;
}

struct PlacedMesh {
  Pose X_OS = Pose::Identity();
  TriangleMesh mesh;
  bool two_sided = false;
};

std::vector<PlacedMesh> MeshesOf(const HybridModel& model) {
  std::vector<PlacedMesh> meshes;
  for (const ShapePart& part : model.shapes) {
    const Mesh* mesh = std::get_if<Mesh>(&part.shape);
    meshes.push_back({.X_OS = part.X_OS,
                      .mesh = Tessellate(part.shape, kSubNoise_m),
                      .two_sided = mesh != nullptr && !mesh->watertight});
  }
  const auto add = [&](const Mesh& mesh) {
    if (mesh.mesh == nullptr) return;
    meshes.push_back({.mesh = *mesh.mesh, .two_sided = !mesh.watertight});
  };
  for (const SurfacePart& part : model.surfaces) add(part.surface);
  for (const Handle& handle : model.handles) add(handle.surface);
  return meshes;
}

void Append(const Mesh& mesh, const Pose& X_OM, TriangleMesh& all) {
  if (mesh.mesh == nullptr) return;
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  for (const Vector3& p : mesh.mesh->vertices) all.vertices.push_back(X_OM * p);
  for (const auto& [a, b, c] : mesh.mesh->triangles) {
    all.triangles.push_back({first + a, first + b, first + c});
  }
}

}  // namespace

ModelSurface::ModelSurface(const HybridModel& model, double reach_m)
    : model_(model), reach_m_(reach_m) {
  TriangleMesh all;
  for (const ShapePart& part : model.shapes) {
    if (const Mesh* mesh = std::get_if<Mesh>(&part.shape)) Append(*mesh, part.X_OS, all);
  }
  for (const SurfacePart& part : model.surfaces) Append(part.surface, Pose::Identity(), all);
  for (const Handle& handle : model.handles) Append(handle.surface, Pose::Identity(), all);
  if (!all.triangles.empty()) tree_.emplace(all);
}

std::optional<SurfacePoint> ModelSurface::Nearest(const Vector3& p_O, double max_distance_m) const {
  std::optional<SurfacePoint> nearest;
  for (const ShapePart& part : model_.shapes) {
    if (std::holds_alternative<Mesh>(part.shape)) continue;  // meshes are in the tree
    const SurfacePoint point_S =
        NearestSurfacePoint(part.shape, part.X_OS.inverse(Eigen::Isometry) * p_O);
    if (nearest && std::abs(nearest->signed_distance_m) <= std::abs(point_S.signed_distance_m)) {
      continue;
    }
    nearest = {.signed_distance_m = point_S.signed_distance_m,
               .nearest = part.X_OS * point_S.nearest,
               .normal = part.X_OS.linear() * point_S.normal};
  }
  if (!tree_) return nearest;
  double limit_m = std::min(reach_m_, max_distance_m);
  if (nearest) limit_m = std::min(limit_m, std::abs(nearest->signed_distance_m));
  const collision::TriangleTree::Nearest on_mesh = tree_->NearestPoint(p_O, limit_m);
  if (!std::isfinite(on_mesh.distance_m)) return nearest;
  const Vector3 normal = on_mesh.distance_m > 0
                             ? Vector3((p_O - on_mesh.point) / on_mesh.distance_m)
                             : on_mesh.face_normal;
  return SurfacePoint{
      .signed_distance_m = on_mesh.distance_m, .nearest = on_mesh.point, .normal = normal};
}

std::vector<SurfaceSample> ModelSurface::Samples(int count) const {
  const std::vector<PlacedMesh> meshes = MeshesOf(model_);
  double area_m2 = 0;
  for (const PlacedMesh& placed : meshes) area_m2 += Area_m2(placed.mesh, placed.X_OS);
  std::vector<SurfaceSample> samples;
  if (!(area_m2 > 0)) return samples;
  Sampler sampler(area_m2 / count, samples);
  for (std::size_t part = 0; part < meshes.size(); ++part) {
    const PlacedMesh& placed = meshes[part];
    for (const auto& [a, b, c] : placed.mesh.triangles) {
      sampler.Add(placed.X_OS * placed.mesh.vertices[a], placed.X_OS * placed.mesh.vertices[b],
                  placed.X_OS * placed.mesh.vertices[c], placed.two_sided, static_cast<int>(part));
    }
  }
  return samples;
}

}  // namespace cwm::perception
