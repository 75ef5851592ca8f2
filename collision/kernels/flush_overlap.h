// Closed meshes whose surfaces touch and nowhere cross: flush faces, copies in one place.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "collision/kernels/exact_geometry.h"
#include "collision/kernels/triangle_overlap.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

// Triangles that cross less deep than this touch: rounding could as well keep them apart, and whether
// room is shared beside them is asked anyway.
inline double TouchingDepth_m(const TriangleTree& a, const TriangleTree& b, const Pose& X_AB) {
  constexpr double kRounding = 1e-14;
  return kRounding * (a.nodes().front().radius_m + b.nodes().front().radius_m +
                      X_AB.translation().norm() + a.bounds().center().norm());
}

// Of mesh A and of mesh B, in the frame of A.
struct TouchingTriangles {
  TrianglePoints a, b;
};

// Both closed, wound outward.
struct ClosedPair {
  const TriangleTree& a;
  const TriangleTree& b;
  const Pose& X_AB;
};

// A point well inside of both, in the frame of A, as deep as a walk from beside a contact gets;
// nothing where they share no room. Where surfaces do not cross, a surface that runs through the
// other solid leaves it where the two touch: beside a line of that contact, next to a face and behind
// it, a point lies in both. Such points are asked for where each pair of triangles touches; room
// thinner than 1e-7 of the meshes, or edges sharper than 3 degrees, may be missed.
std::optional<Vector3> PointInBoth(const ClosedPair& pair,
                                   std::span<const TouchingTriangles> touching, WorkCounter* work);

}  // namespace cwm::collision
