// Proofs that an answer about two convex shapes is right, from independent formulas: the height of
// a shape along a direction, and the signed distance of a witness point from its shape.
#pragma once

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_distance.h"

namespace cwm::collision {

// The maximum of n . x over the points of a bounded convex shape or plate; `n` is a unit vector.
double HeightAlong(const Shape& shape, const Pose& X_FS, const Vector3& n);

struct PosedPair {
  Shape a, b;
  Pose X_FA = Pose::Identity(), X_FB = Pose::Identity();
};

// The translation of B along `n` that puts it beyond A; negative if it already is.
double OverlapAlong(const PosedPair& pair, const Vector3& n);

// The size of both shapes and of their offset, relative to which rounding is measured.
double SizeOf(const PosedPair& pair);

// The errors of an answer in metres, 0 if perfect. For separated shapes they prove the distance:
// the witness points bound it from above, and the gap along the normal from below.
struct AnswerErrors {
  double distance_m = 0;  // against the overlap along the normal
  double witness_m = 0;   // from the surfaces, and from the distance along the normal
  double normal = 0;      // from unit length
};
AnswerErrors ErrorsOf(const PosedPair& pair, const PairDistance& answer);

// The smallest overlap that local descents find from a direction that is nearly optimal; they stop
// once it is at most `enough_m`.
double MinOverlapNear(const PosedPair& pair, const Vector3& n, double enough_m);

// The smallest overlap over sampled directions and local descents from the best of them: a close
// upper bound on the minimum translation.
double SearchMinOverlap(const PosedPair& pair, int samples, unsigned seed);

}  // namespace cwm::collision
