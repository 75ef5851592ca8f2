// Where a box lies, as a string of bits: what places a box in a BoundsTree.
#pragma once

#include <array>
#include <cstdint>

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// The bits of the box's centre, interleaved axis by axis from the most significant on (Morton
// 1966), followed by a salt that tells boxes of one centre apart. Boxes with a long common prefix
// are near each other.
struct PlaceKey {
  std::array<std::uint64_t, 3> cell;  // of x, y, z
  std::uint64_t salt = 0;
};

// The box is neither empty nor unbounded.
PlaceKey KeyOf(const Aabb& box, std::uint64_t salt);

// The first bit in which the two differ, counted from the last one, 0; -1 when they are equal.
int FirstDifference(const PlaceKey& a, const PlaceKey& b);

bool BitAt(const PlaceKey& key, int bit);

}  // namespace cwm::collision
