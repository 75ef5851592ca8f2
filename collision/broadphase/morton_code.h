// The position of a box as a string of bits, which is its key in a BoundsTree.
#pragma once

#include <array>
#include <cstdint>

#include "collision/geometry/aabb.h"

namespace cwm::collision {

// The coordinates of the box's centre as interleaved bits, most significant first (Morton 1966),
// followed by a salt that separates boxes with equal centres. Boxes with a long common prefix are
// near each other.
struct MortonCode {
  std::array<std::uint64_t, 3> cell;  // of x, y, z
  std::uint64_t salt = 0;
};

// `box` must be neither empty nor unbounded.
MortonCode KeyOf(const Aabb& box, std::uint64_t salt);

// The most significant bit in which the two differ, counted from the last bit, which is 0; -1 if
// they are equal.
int FirstDifference(const MortonCode& a, const MortonCode& b);

bool BitAt(const MortonCode& key, int bit);

}  // namespace cwm::collision
