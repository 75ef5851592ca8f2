// The surface of a known object's model, prepared for distances of points and for samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/hybrid_model.h"
#include "collision/geometry/signed_distance.h"

namespace cwm::perception {

// chosen: samples of one surface; they determine shares of it to about 5 percent.
inline constexpr int kSurfaceSamples = 400;

// A point of a surface in the object's frame that represents an area of it.
struct SurfaceSample {
  Vector3 p_O = Vector3::Zero();
  Vector3 normal_O = Vector3::UnitZ();  // outward
  bool two_sided = false;               // of an open mesh: seen from either side
};

// Immutable. Distances are exact. The triangles of all meshes are in a spatial hash, so that a
// query takes the same time for large and small meshes.
class ModelSurface {
 public:
  // Distances beyond `reach_m` (positive) are not found for meshes. The model must outlive this.
  ModelSurface(const HybridModel& model, double reach_m);

  // The nearest point over all parts, by unsigned distance. Empty if there are only meshes and none
  // is within reach.
  std::optional<SurfacePoint> Nearest(const Vector3& p_O) const;

  // About `count` samples, evenly over all parts. Deterministic.
  std::vector<SurfaceSample> Samples(int count) const;

 private:
  struct MeshTriangle {
    Vector3 a, b, c;
  };

  void AddMesh(const TriangleMesh& mesh, const Pose& X_OM);
  void AddTriangle(const MeshTriangle& triangle);
  static std::uint64_t Key(const Eigen::Vector3i& cell);
  Eigen::Vector3i CellOf(const Vector3& p_O) const;

  const HybridModel& model_;
  double reach_m_;
  std::vector<MeshTriangle> triangles_;
  std::vector<std::uint32_t> large_;  // triangles that fill too many cells
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace cwm::perception
