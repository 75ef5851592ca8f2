// A ray against boxes.
#pragma once

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// A ray prepared for slab tests (Kay and Kajiya 1986). A direction component of 0 is handled
// exactly: such a ray stays between two slabs for ever or never gets there.
class SlabRay {
 public:
  SlabRay(const Vector3& origin, const Vector3& direction);

  // Length at which the ray enters the box, 0 when it starts inside, infinite when it misses.
  double Entry_m(const Aabb& box) const;

 private:
  Vector3 origin_;
  Vector3 inverse_;  // infinite where the direction has no component
};

}  // namespace cwm::collision
