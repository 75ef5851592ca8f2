#include "collision/broadphase/morton_code.h"

#include <algorithm>
#include <bit>

namespace cwm::collision {
namespace {

constexpr int kSaltBits = 64;

// chosen: a cell of the finest grid is a micrometre; a finer order of boxes gains nothing.
constexpr double kCell_m = 0x1p-20;

// derived: four times kMaxCoordinate_m. Centres farther out share the outermost cell.
constexpr double kReach_m = 0x1p22;

std::uint64_t CellOf(double centre_m) {
  const double clamped_m = std::clamp(centre_m, -kReach_m, kReach_m);
  return static_cast<std::uint64_t>((clamped_m + kReach_m) / kCell_m);
}

// The index of the highest bit that is set, -1 if none is.
int HighestBit(std::uint64_t bits) { return static_cast<int>(std::bit_width(bits)) - 1; }

}  // namespace

MortonCode KeyOf(const Aabb& box, std::uint64_t salt) {
  const Vector3 centre = box.center();
  return {{CellOf(centre.x()), CellOf(centre.y()), CellOf(centre.z())}, salt};
}

int FirstDifference(const MortonCode& a, const MortonCode& b) {
  int first = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t differing = a.cell[axis] ^ b.cell[axis];
    if (differing != 0) first = std::max(first, 3 * HighestBit(differing) + 2 - axis);
  }
  if (first >= 0) return kSaltBits + first;
  return HighestBit(a.salt ^ b.salt);
}

bool BitAt(const MortonCode& key, int bit) {
  if (bit < kSaltBits) return (key.salt >> bit) & 1;
  const int place = bit - kSaltBits;
  return (key.cell[2 - place % 3] >> (place / 3)) & 1;
}

}  // namespace cwm::collision
