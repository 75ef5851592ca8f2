// The visible points of solids that stand on z = 0 and do not hide each other: exact points spread
// evenly over their surfaces, for the tests of fits of whole solids.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "perception/fit/solid.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {

class SeenOnGround {
 public:
  // `count` points in all, equally many of each solid. Poses are in the frame of the ground.
  SeenOnGround(const Vector3& eye, const std::vector<Placed<>>& solids, std::size_t count)
      : points_(SubsampleForSearch(Seen(eye, solids, count), count)),
        octree_(points_),
        connectivity_(points_) {}

  FitContext Context() const { return ContextOf(points_); }
  // The context of a subset of the points (see Subset).
  FitContext ContextOf(const ModelPoints& points) const {
    return {points,
            octree_,
            connectivity_,
            noise_,
            options,
            work_,
            Ground{.known = true, .point = -points_.origin_L}};
  }

  // The solid as an assembly has it, in the frame of the points.
  Solid Assembled(const Placed<>& placed) const {
    Solid solid;
    solid.X_MS = Eigen::Translation3d(-points_.origin_L) * placed.X_FS;
    solid.shape = placed.shape;
    return solid;
  }

  // The middle of a solid, in the frame of the ground.
  Vector3 MiddleOf(const Solid& solid) const { return solid.X_MS.translation() + points_.origin_L; }

  const ModelPoints& points() const { return points_; }

  ModelerOptions options;

 private:
  static OrientedPoints Seen(const Vector3& eye, const std::vector<Placed<>>& solids,
                             std::size_t count) {
    constexpr double kFoot_m = 0.006;    // hidden in the band of the support
    constexpr double kShell_m = 0.001;   // points begin this near to a surface, then move onto it
    constexpr double kMinToEye_m = 0.1;  // along the normal: grazing faces are not seen
    OrientedPoints points;
    points.viewpoint = eye;
    RandomDraws random(1, 0);
    for (std::size_t k = 0; k < solids.size(); ++k) {
      const Placed<>& solid = solids[k];
      const Vector3 half = 0.5 * TightBounds(solid.shape, Pose::Identity()).sizes();
      const Vector3 reach = half + Vector3::Constant(kShell_m);
      while (points.size() < count * (k + 1) / solids.size()) {
        Vector3 p_S;
        for (int axis = 0; axis < 3; ++axis) p_S[axis] = random.Uniform(-reach[axis], reach[axis]);
        const SurfacePoint at = NearestSurfacePoint(solid.shape, p_S);
        const Vector3 p = solid.X_FS * at.nearest, n = solid.X_FS.linear() * at.normal;
        if (std::abs(at.signed_distance_m) > kShell_m || p.z() < kFoot_m) continue;
        if (n.dot(eye - p) < kMinToEye_m) continue;
        points.points.push_back(p.cast<float>());
        points.normals.push_back(n.cast<float>());
        points.sigma_m.push_back(0.0015f);
        points.normal_sigma_rad.push_back(0.05f);
        points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
      }
    }
    return points;
  }

  const ModelPoints points_;
  const Octree octree_;
  const Connectivity connectivity_;
  const SensorNoise noise_;
  const Work work_;
};

}  // namespace cwm::perception
