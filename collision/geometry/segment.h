// Nearest points on a line segment, in two or three dimensions.
#pragma once

#include <algorithm>

namespace cwm {

// The point of the segment from `a` to `b` nearest to `p`; `a` when the segment has no length.
template <class Vector>
Vector NearestOnSegment(const Vector& a, const Vector& b, const Vector& p) {
  const Vector ab = b - a;
  const double length_squared = ab.squaredNorm();
  if (!(length_squared > 0)) return a;
  const double t = (p - a).dot(ab) / length_squared;
  if (t >= 1) return b;  // the vertex itself, free of rounding
  return a + std::max(t, 0.0) * ab;
}

}  // namespace cwm
