// Cells of a sparse grid in the world.
#pragma once

#include <cstdint>

#include "collision/geometry/pose.h"

namespace cwm::perception {

// chosen: poses of moving sensors err by some millimetres, and by 15 mm at 2 m.
inline constexpr double kWorldCell_m = 0.03;

using WorldCell = Eigen::Matrix<std::int64_t, 3, 1>;

inline WorldCell CellOf(const Vector3& p_W) {
  return (p_W / kWorldCell_m).array().floor().cast<std::int64_t>();
}

// Equal for equal cells, and for others only if they are 60 km apart.
inline std::uint64_t KeyOf(const WorldCell& cell) {
  constexpr int kBits = 21;  // per axis
  constexpr std::int64_t kMask = (std::int64_t{1} << kBits) - 1;
  return static_cast<std::uint64_t>((cell.x() & kMask) << (2 * kBits) |
                                    (cell.y() & kMask) << kBits | (cell.z() & kMask));
}

}  // namespace cwm::perception
