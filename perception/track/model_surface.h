// The surface of a known object's model, prepared for distances of points and for samples.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/hybrid_model.h"
#include "collision/geometry/signed_distance.h"
#include "collision/kernels/triangle_tree.h"

namespace cwm::perception {

// chosen: samples of one surface; they determine shares of it to about 5 percent.
inline constexpr int kSurfaceSamples = 400;

// A point of a surface in the object's frame that represents an area of it.
struct SurfaceSample {
  Vector3 p_O = Vector3::Zero();
  Vector3 normal_O = Vector3::UnitZ();  // outward
  bool two_sided = false;               // of an open mesh: seen from either side
  int part = 0;                         // of the model: shapes, surfaces, then handles
};

// Immutable. Distances are exact. The triangles of all meshes are in one tree.
class ModelSurface {
 public:
  // Distances beyond `reach_m` (positive) are not found for meshes. The model must outlive this.
  ModelSurface(const HybridModel& model, double reach_m);

  // The nearest point over all parts, by unsigned distance. Empty if there are only meshes and none
  // is within reach, or within `max_distance_m` if that is less.
  std::optional<SurfacePoint> Nearest(
      const Vector3& p_O, double max_distance_m = std::numeric_limits<double>::infinity()) const;

  // About `count` samples, evenly over all parts. Deterministic.
  std::vector<SurfaceSample> Samples(int count) const;

 private:
  const HybridModel& model_;
  double reach_m_;
  std::optional<collision::TriangleTree> tree_;  // of all meshes; empty without one
};

}  // namespace cwm::perception
