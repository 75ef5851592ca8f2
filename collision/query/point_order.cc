#include "collision/query/point_order.h"

#include <array>
#include <limits>

#include "collision/geometry/aabb.h"

namespace cwm::collision {
namespace {

// Spreads the bits of a 4-bit number to every third bit: 0b1011 becomes 0b001000001001.
constexpr std::array<std::uint16_t, 16> SpreadBits() {
  std::array<std::uint16_t, 16> spread{};
  for (unsigned i = 0; i < spread.size(); ++i) {
    for (unsigned bit = 0; bit < 4; ++bit) {
      spread[i] = static_cast<std::uint16_t>(spread[i] | ((i >> bit & 1) << (3 * bit)));
    }
  }
  return spread;
}

}  // namespace

std::span<const std::uint32_t> PointOrder::Sort(std::span<const Vector3> points) {
  static constexpr std::array<std::uint16_t, 16> kSpreadBits = SpreadBits();
  Aabb bounds;
  for (const Vector3& p : points) bounds.extend(p);
  const double extent_m = bounds.isEmpty() ? 0 : bounds.sizes().maxCoeff();
  // Scaled so that the farthest point still falls into the last cell.
  const double cells_per_m = extent_m > 0 ? (1 << kBitsPerAxis) * (1 - 1e-12) / extent_m : 0;
  cells_.resize(points.size());
  begins_.assign(kCells + 1, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 at = (points[i] - bounds.min()) * cells_per_m;
    const auto cell = static_cast<std::uint16_t>(kSpreadBits[static_cast<int>(at.x()) & 15] |
                                                 kSpreadBits[static_cast<int>(at.y()) & 15] << 1 |
                                                 kSpreadBits[static_cast<int>(at.z()) & 15] << 2);
    cells_[i] = cell;
    ++begins_[cell + 1u];
  }
  for (std::size_t c = 0; c < kCells; ++c) begins_[c + 1] += begins_[c];
  indices_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    indices_[begins_[cells_[i]]++] = static_cast<std::uint32_t>(i);
  }
  return indices_;
}

}  // namespace cwm::collision
