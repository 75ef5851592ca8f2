#include "collision/broadphase/slab_ray.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::collision {

SlabRay::SlabRay(const Vector3& origin, const Vector3& direction)
    : origin_(origin), inverse_(direction.cwiseInverse()) {}

double SlabRay::Entry_m(const Aabb& box) const {
  constexpr double kMiss = std::numeric_limits<double>::infinity();
  double enter = 0;
  double leave = kMiss;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isinf(inverse_[axis])) {
      if (origin_[axis] < box.min()[axis] || origin_[axis] > box.max()[axis]) return kMiss;
      continue;
    }
    const double at_min = (box.min()[axis] - origin_[axis]) * inverse_[axis];
    const double at_max = (box.max()[axis] - origin_[axis]) * inverse_[axis];
    enter = std::max(enter, std::min(at_min, at_max));
    leave = std::min(leave, std::max(at_min, at_max));
  }
  return enter <= leave ? enter : kMiss;
}

}  // namespace cwm::collision
