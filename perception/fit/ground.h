// The support plane of an object, as the modeler sees it.
#pragma once

#include "collision/geometry/pose.h"

namespace cwm::perception {

// The plane that the object stands on, in the frame of the model points.
struct Ground {
  bool known = false;
  Vector3 up = Vector3::UnitZ();    // unit
  Vector3 point = Vector3::Zero();  // a point of the plane

  double Height_m(const Vector3& p) const { return up.dot(p - point); }
};

}  // namespace cwm::perception
