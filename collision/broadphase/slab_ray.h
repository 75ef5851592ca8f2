// Intersection of a ray with boxes.
#pragma once

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// A ray prepared for slab tests (Kay and Kajiya 1986). A direction component of 0 is handled
// exactly: along that axis the ray is either always or never within the box.
class SlabRay {
 public:
  SlabRay(const Vector3& origin, const Vector3& direction);

  // The length at which the ray enters the box: 0 if it starts inside, infinite if it misses.
  double Entry_m(const Aabb& box) const;

 private:
  Vector3 origin_;
  Vector3 inverse_;  // infinite where the direction has no component
};

}  // namespace cwm::collision
