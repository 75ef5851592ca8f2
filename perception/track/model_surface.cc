#include "perception/track/model_surface.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/tessellate.h"
#include "collision/geometry/triangle.h"
#include "perception/cloud/morton.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the largest number of cells that one triangle may fill; larger triangles belong to
// shapes, not to scanned meshes. It only affects the time.
constexpr int kMaxCellsOfTriangle = 64;

// Takes one sample for each full `area_m2` that accumulates over the triangles.
class Sampler {
 public:
  Sampler(double area_m2, std::vector<SurfaceSample>& samples)
      : area_m2_(area_m2), samples_(samples) {}

  // Small triangles are sampled at their centre, large ones at the centres of equal divisions.
  void Add(const Vector3& a, const Vector3& b, const Vector3& c, bool two_sided) {
    const double triangle_m2 = 0.5 * (b - a).cross(c - a).norm();
    const int divisions =
        std::clamp(static_cast<int>(std::ceil(std::sqrt(triangle_m2 / area_m2_))), 1, 100);
    const Vector3 normal = TriangleNormal(a, b, c);
    const auto offer = [&](double i, double j) {
      waiting_m2_ += triangle_m2 / (divisions * divisions);
      if (waiting_m2_ < area_m2_) return;
      waiting_m2_ -= area_m2_;
      const Vector3 p = a + (i * (b - a) + j * (c - a)) / divisions;
      samples_.push_back({.p_O = p, .normal_O = normal, .two_sided = two_sided});
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

}  // namespace

ModelSurface::ModelSurface(const HybridModel& model, double reach_m)
    : model_(model), reach_m_(reach_m) {
  for (const ShapePart& part : model.shapes) {
    if (const Mesh* mesh = std::get_if<Mesh>(&part.shape)) AddMesh(*mesh->mesh, part.X_OS);
  }
  for (const SurfacePart& part : model.surfaces) {
    if (part.surface.mesh != nullptr) AddMesh(*part.surface.mesh, Pose::Identity());
  }
  for (const Handle& handle : model.handles) {
    if (handle.surface.mesh != nullptr) AddMesh(*handle.surface.mesh, Pose::Identity());
  }
}

std::uint64_t ModelSurface::Key(const Eigen::Vector3i& cell) {
  const Eigen::Matrix<std::uint32_t, 3, 1> at = cell.cast<std::uint32_t>();  // the lowest bits
  return MortonKey(at.x(), at.y(), at.z());
}

Eigen::Vector3i ModelSurface::CellOf(const Vector3& p_O) const {
  // Meshes are a few metres large; places far outside share cells, which only costs time.
  const double farthest = 1 << (kMortonBitsPerAxis - 1);
  return (p_O / reach_m_).array().floor().max(-farthest).min(farthest).cast<int>();
}

void ModelSurface::AddMesh(const TriangleMesh& mesh, const Pose& X_OM) {
  for (const auto& [a, b, c] : mesh.triangles) {
    AddTriangle({X_OM * mesh.vertices[a], X_OM * mesh.vertices[b], X_OM * mesh.vertices[c]});
  }
}

void ModelSurface::AddTriangle(const MeshTriangle& triangle) {
  const auto index = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back(triangle);
  const Eigen::Vector3i low = CellOf(triangle.a.cwiseMin(triangle.b).cwiseMin(triangle.c));
  const Eigen::Vector3i high = CellOf(triangle.a.cwiseMax(triangle.b).cwiseMax(triangle.c));
  const auto count = (high - low + Eigen::Vector3i::Ones()).cast<double>().prod();
  if (count > static_cast<double>(kMaxCellsOfTriangle)) {
    large_.push_back(index);
    return;
  }
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int z = low.z(); z <= high.z(); ++z) cells_[Key({x, y, z})].push_back(index);
    }
  }
}

std::optional<SurfacePoint> ModelSurface::Nearest(const Vector3& p_O) const {
  std::optional<SurfacePoint> nearest;
  const auto offer = [&](const SurfacePoint& point) {
    if (nearest && std::abs(nearest->signed_distance_m) <= std::abs(point.signed_distance_m)) {
      return;
    }
    nearest = point;
  };
  for (const ShapePart& part : model_.shapes) {
    if (std::holds_alternative<Mesh>(part.shape)) continue;  // meshes are in the hash
    const SurfacePoint point_S = NearestSurfacePoint(part.shape, part.X_OS.inverse() * p_O);
    offer({.signed_distance_m = point_S.signed_distance_m,
           .nearest = part.X_OS * point_S.nearest,
           .normal = part.X_OS.linear() * point_S.normal});
  }
  const auto offer_triangles = [&](const std::vector<std::uint32_t>& indices) {
    for (const std::uint32_t index : indices) {
      const auto& [a, b, c] = triangles_[index];
      const Vector3 q = NearestOnTriangle(a, b, c, p_O);
      const double distance_m = (p_O - q).norm();
      if (nearest && std::abs(nearest->signed_distance_m) <= distance_m) continue;
      const Vector3 normal =
          distance_m > 0 ? Vector3((p_O - q) / distance_m) : TriangleNormal(a, b, c);
      nearest = {.signed_distance_m = distance_m, .nearest = q, .normal = normal};
    }
  };
  offer_triangles(large_);
  if (cells_.empty()) return nearest;
  const Eigen::Vector3i center = CellOf(p_O);
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i beside(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const auto cell = cells_.find(Key(center + beside));
    if (cell != cells_.end()) offer_triangles(cell->second);
  }
  return nearest;
}

std::vector<SurfaceSample> ModelSurface::Samples(int count) const {
  const std::vector<PlacedMesh> meshes = MeshesOf(model_);
  double area_m2 = 0;
  for (const PlacedMesh& placed : meshes) area_m2 += Area_m2(placed.mesh, placed.X_OS);
  std::vector<SurfaceSample> samples;
  if (!(area_m2 > 0)) return samples;
  Sampler sampler(area_m2 / count, samples);
  for (const PlacedMesh& placed : meshes) {
    for (const auto& [a, b, c] : placed.mesh.triangles) {
      sampler.Add(placed.X_OS * placed.mesh.vertices[a], placed.X_OS * placed.mesh.vertices[b],
                  placed.X_OS * placed.mesh.vertices[c], placed.two_sided);
    }
  }
  return samples;
}

}  // namespace cwm::perception
