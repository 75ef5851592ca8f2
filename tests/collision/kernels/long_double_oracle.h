// Signed distances of the pairs that have a formula, written anew in extended precision (64 bits of
// mantissa): what the kernels' doubles have lost is visible against it.
#pragma once

#include "tests/collision/kernels/pair_oracle.h"

namespace cwm::collision {

// Pairs of a sphere with anything convex but a hull, of a half-space with anything bounded, capsule
// with capsule and box with capsule, in this or the other order. Plates are rectangles from the
// origin, as RandomPairs makes them.
bool HasLongDoubleOracle(ShapeKind a, ShapeKind b);

// Precondition: HasLongDoubleOracle.
long double LongDoubleDistance_m(const PosedPair& pair);

// The larger of both shapes' extents (a half-space has none) and the offset of their frames.
double ExtentOf(const PosedPair& pair);

}  // namespace cwm::collision
