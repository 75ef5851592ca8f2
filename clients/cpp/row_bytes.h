// Rows of numbers in the form of the API's bulk `bytes` fields: little-endian doubles, one row
// after the other.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

namespace cwm::client {

using PoseRow = std::array<double, 7>;  // tx ty tz qx qy qz qw, metres
using RayRow = std::array<double, 6>;   // origin x y z, direction x y z
using PointRow = std::array<double, 3>;

template <std::size_t N>
std::string RowBytes(const std::vector<std::array<double, N>>& rows) {
  std::string bytes(rows.size() * N * sizeof(double), '\0');
  if (!rows.empty()) std::memcpy(bytes.data(), rows.data(), bytes.size());
  return bytes;
}

}  // namespace cwm::client
