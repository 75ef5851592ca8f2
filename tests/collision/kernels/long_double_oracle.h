// Signed distances of pairs with a closed form, written again in extended precision (64 bits of
// mantissa), to show the digits that the kernels' doubles lose.
#pragma once

#include "tests/collision/kernels/pair_oracle.h"

namespace cwm::collision {

// True for a sphere with any convex shape except a hull, a half-space with any bounded shape, two
// capsules, and a box with a capsule, in either order. Plates must be rectangles from the origin,
// as RandomPairs makes them.
bool HasLongDoubleOracle(ShapeKind a, ShapeKind b);

// Precondition: HasLongDoubleOracle.
long double LongDoubleDistance_m(const PosedPair& pair);

// The largest of both shapes' extents (0 for a half-space) and the offset of their frames.
double ExtentOf(const PosedPair& pair);

}  // namespace cwm::collision
