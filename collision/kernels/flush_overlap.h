// Overlap of closed meshes whose surfaces touch but do not cross: flush faces, copies at one pose.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "collision/kernels/exact_geometry.h"
#include "collision/kernels/triangle_overlap.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

// Triangles that cross by less than this depth count as touching: rounding could just as well
// separate them, and FindPointInBoth decides whether the solids overlap there.
inline double TouchingDepth_m(const TriangleTree& a, const TriangleTree& b, const Pose& X_AB) {
  constexpr double kRounding = 1e-14;
  return kRounding * (a.nodes().front().radius_m + b.nodes().front().radius_m +
                      X_AB.translation().norm() + a.bounds().center().norm());
}

// A triangle of mesh A and one of mesh B, in the frame of A.
struct TouchingTriangles {
  TrianglePoints a, b;
};

// Two closed meshes, wound outward.
struct ClosedPair {
  const TriangleTree& a;
  const TriangleTree& b;
  const Pose& X_AB;
};

// A point inside both meshes, in the frame of A, as deep as a walk away from a contact gets; empty
// if they share no volume. If surfaces do not cross, a surface that runs through the other solid
// leaves it where the two touch, so that a point beside a line of that contact, just behind a face,
// lies in both. Such points are tested at each pair of touching triangles. Shared volumes thinner
// than 1e-7 of the meshes' size, or edges sharper than 3 degrees, may be missed.
std::optional<Vector3> FindPointInBoth(const ClosedPair& pair,
                                       std::span<const TouchingTriangles> touching,
                                       WorkCounter* work);

}  // namespace cwm::collision
