// Proofs that an answer about two convex shapes is right, by formulas of their own: the height of a
// shape along a direction, and the signed distance of a witness to its shape.
#pragma once

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_answer.h"

namespace cwm::collision {

// The largest n . x over the points of a bounded convex shape or plate, `n` unit.
double HeightAlong(const Shape& shape, const Pose& X_FS, const Vector3& n);

struct PosedPair {
  Shape a, b;
  Pose X_FA = Pose::Identity(), X_FB = Pose::Identity();
};

// How far B must move along `n` to lie beyond A: negative when it does already.
double OverlapAlong(const PosedPair& pair, const Vector3& n);

// The sizes of both shapes and of their offset: what rounding is measured against.
double SizeOf(const PosedPair& pair);

// Errors of an answer in metres, 0 when perfect. For separated shapes they prove the distance: the
// witnesses bound it from above, the gap along the normal from below.
struct AnswerErrors {
  double distance_m = 0;  // against the overlap along the normal
  double witness_m = 0;   // from their surfaces, and from each other against distance and normal
  double normal = 0;      // from unit length
};
AnswerErrors ErrorsOf(const PosedPair& pair, const PairDistance& answer);

// The smallest overlap that local descents find from a direction that is nearly the best; they end
// at one of `enough_m`.
double LeastOverlapNear(const PosedPair& pair, const Vector3& n, double enough_m);

// The smallest overlap found over sampled directions and local descents from the best of them; an
// upper bound of the least translation that comes near to it.
double SearchedLeastOverlap(const PosedPair& pair, int samples, unsigned seed);

}  // namespace cwm::collision
