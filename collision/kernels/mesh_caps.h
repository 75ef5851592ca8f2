// The error of answers about meshes whose holes were closed (MeshCap).
//
// Let S be the true solid, K the closed mesh and H the convex hulls of the holes' boundaries. S and
// K are equal outside of H, both have the boundaries, and no point of a hull is farther from its
// boundary than the bound of its cap. So:
// * a distance is that of S if the other shape is farther from H;
// * another distance is off by at most the bounds of the caps that are nearer, unless the other
//   shape meets H: then S may overlap it, no deeper than the convex hull of K, which contains S;
// * an overlap and its depth are those of S if the other shape is farther from H than the
//   translation that ends it. Another may be none, and the shapes then are no farther apart than
//   the bounds.
// Half-spaces meet S where they meet K, since the lowest point of K is a corner of the file.
#pragma once

#include "collision/kernels/exact.h"

namespace cwm::collision {

// The error of the distance of a pair, given that only holes within some reach of the other shape
// matter.
struct CapError {
  double apart_m = 0;  // the most by which the distance may be off; 0 if no hole matters
  double depth_m = 0;  // the most by which shapes may overlap that are told to be apart
  bool any() const { return apart_m > 0; }
};

// Looks at the holes of both shapes. `reach_m` is not negative. Every hole is looked at, unless
// there are none.
CapError CapErrorOf(const PlacedExact& a, const PlacedExact& b, double reach_m,
                    WorkCounter* work = nullptr);

// The same for the distance of a point in the frame of the shape.
CapError CapErrorAt(const ExactGeometry& shape, const Vector3& p, double reach_m);

// True if a hole's hull may lie on the ray within its range, so that its hit may be another.
bool MayMeetCap(const PlacedExact& shape, const Ray& ray);

// The answer about a pair with the error added to its bound: kBounded instead of kExact if there
// is any. The holes within |distance_m| + bound_m matter.
PairDistance WithCapError(const PairDistance& answer, const CapError& error);

}  // namespace cwm::collision
