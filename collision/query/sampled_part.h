// A part of the world in the form that SamplePoints uses, and the parts that a batch has met so
// far.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "collision/kernels/kink.h"
#include "collision/kernels/mesh_caps.h"
#include "collision/kernels/point_sample.h"
#include "collision/kernels/solid_lanes.h"
#include "collision/query/object_ranks.h"
#include "collision/query/world_filter.h"

namespace cwm::collision {

// Refers to an object of the queried snapshot.
class SampledPart {
 public:
  struct Id {
    std::int32_t object = 0;  // WorldSnapshot::IndexOf
    std::int32_t part = 0;
    std::int32_t by_name = 0;  // rank among all objects and robots, ordered by name
  };
  SampledPart(const Obstacle& object, const Id& id);
  SampledPart(const SampledPart&) =
      delete;  // it refers to its own heap memory, which a move takes along
  SampledPart(SampledPart&&) = default;

  const Id& id() const { return id_; }
  // The order of equally near parts: by object name, then part.
  std::int64_t order() const { return (std::int64_t{id_.by_name} << 32) | id_.part; }
  const Aabb& bounds_W() const { return *bounds_W_; }
  bool is_open() const { return tree_ != nullptr && !watertight_; }

  // Signed distances of the points from the solid, in metres. For a point farther than `reach_m`
  // plus kKinkTolerance_m, any value above that.
  void Measure(const BlockPoints& points_W, const BlockDistances& reach_m,
               BlockDistances& distances_m, WorkCounter* work = nullptr) const;
  double Distance_m(const Vector3& p_W, WorkCounter* work = nullptr) const;

  // The solid for SampleLanes; nullptr if points must be sampled one by one with Sample.
  const LaneSolid* lanes() const { return short_formula_ ? &solid_ : nullptr; }
  // The error of the distance of a point, given that closed holes within `reach_m` of it matter.
  CapError CapErrorAt(const Vector3& p_W, double reach_m) const;
  // Samples one point. `distance_m` is the result of Measure or Distance_m for it.
  PointSample Sample(const Vector3& p_W, double distance_m, WorkCounter* work = nullptr) const;
  // The distance from a point in the solid of a closed mesh, along a unit direction, to the point
  // where the ray leaves the solid; empty if rounding hides that point.
  std::optional<double> ExitDistance_m(const Vector3& p_W, const Vector3& direction_W,
                                       WorkCounter* work = nullptr) const;

 private:
  void Prepare(const Sphere& sphere);
  void Prepare(const Box& box);
  void Prepare(const Cylinder& cylinder);
  void Prepare(const Cone& cone);
  void Prepare(const Capsule& capsule);
  void Prepare(const HalfSpace& half_space);
  void Prepare(const Plate& plate);
  void Prepare(const Convex& convex);
  void Prepare(const Mesh& mesh);
  void PrepareProfile(PlaneProfile profile, LaneSolid::Form form);
  Vector3 InShape(const Vector3& p_W) const {
    return X_WP_.linear().transpose() * (p_W - X_WP_.translation());
  }
  PointSample SampleProfile(const Vector3& p) const;
  double DistanceInShape_m(const Vector3& p, double max_distance_m, WorkCounter* work) const;

  Id id_;
  const PreparedPart* part_;
  const Shape* shape_;  // the shape as the kernels use it
  const Aabb* bounds_W_;
  Pose X_WP_;
  LaneSolid solid_;
  bool in_lanes_ = true;        // true if Measure handles all points at once by SIMD
  bool short_formula_ = false;  // true if SampleLanes can sample the part
  std::optional<PlaneProfile> profile_;
  const TriangleTree* tree_ = nullptr;
  bool watertight_ = false;
};

// Creates the parts of an object on first use. Used by one thread.
class SampledParts {
 public:
  SampledParts(const WorldSnapshot& world, const WorldFilter& filter)
      : world_(world), filter_(filter), ranks_(world) {}

  // The parts of an object of the world that pass the filter.
  std::span<const SampledPart> PartsOf(const Obstacle& object);

 private:
  const WorldSnapshot& world_;
  const WorldFilter& filter_;
  ObjectRanks ranks_;
  std::unordered_map<const Obstacle*, std::vector<SampledPart>> parts_;
};

}  // namespace cwm::collision
