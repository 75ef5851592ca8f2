#include "collision/query/hidden_spaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"

namespace cwm::collision {

double HiddenSpace::Distance_m(const Vector3& p_W) const {
  return SignedDistance_m(box, X_WB.inverse(Eigen::Isometry) * p_W);
}

double HiddenSpace::LowerBound_m(const Aabb& other_W) const {
  const double of_boxes_m = std::sqrt(SquaredDistance_m2(bounds_W, other_W));
  const double of_spheres_m = Distance_m(other_W.center()) - 0.5 * other_W.sizes().norm();
  return std::max(of_boxes_m, of_spheres_m);
}

double HiddenSpace::Entry_m(const Vector3& origin_W, const Vector3& direction_W) const {
  const Pose X_BW = X_WB.inverse(Eigen::Isometry);
  const Vector3 origin = X_BW * origin_W, direction = X_BW.linear() * direction_W;
  double entry_m = 0, exit_m = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double half_m = 0.5 * box.size_m[k];
    if (direction[k] == 0) {
      if (std::abs(origin[k]) > half_m) return std::numeric_limits<double>::infinity();
      continue;
    }
    double near_m = (-half_m - origin[k]) / direction[k];
    double far_m = (half_m - origin[k]) / direction[k];
    if (near_m > far_m) std::swap(near_m, far_m);
    entry_m = std::max(entry_m, near_m);
    exit_m = std::min(exit_m, far_m);
  }
  return entry_m <= exit_m ? entry_m : std::numeric_limits<double>::infinity();
}

std::vector<HiddenSpace> HiddenSpacesOf(const WorldSnapshot& world, const WorldFilter& filter) {
  std::vector<HiddenSpace> spaces;
  for (const WorldObjectPtr& object : world.with_hidden()) {
    if (filter.Skips(*object)) continue;
    const std::vector<ShapePart>& shapes = object->model().shapes;
    for (std::size_t k = 0; k < shapes.size(); ++k) {  // shapes are the first parts
      if (!shapes[k].hidden || filter.SkipsPart(*object, k)) continue;
      const Pose X_WB = object->X_WO * shapes[k].hidden->X_FS;
      const Box& box = shapes[k].hidden->shape;
      spaces.push_back({.object = object.get(),
                        .part = static_cast<std::int32_t>(k),
                        .X_WB = X_WB,
                        .box = box,
                        .bounds_W = TightBounds(box, X_WB),
                        .depth_m = HiddenDepth_m(shapes[k])});
    }
  }
  return spaces;
}

}  // namespace cwm::collision
