// Axis-aligned bounds, as tight as the placed shape allows.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm {

using Aabb = Eigen::AlignedBox3d;

// The smallest axis-aligned box in frame F around a shape S placed at X_FS, exact for every shape.
// A half-space reaches to infinity, except where its normal is an axis of F.
Aabb TightBounds(const Shape& shape, const Pose& X_FS);

// The minimum translation along an axis of the frame that separates two overlapping boxes, an upper
// bound of the depth of their contents.
inline double MinSeparation_m(const Aabb& a, const Aabb& b) {
  return (a.max() - b.min()).cwiseMin(b.max() - a.min()).minCoeff();
}

}  // namespace cwm
