#include "perception/segmentation/footprint.h"

#include <algorithm>
#include <cmath>

namespace cwm::perception {
namespace {

void Extend(std::map<int, std::pair<int, int>>& ranges, int key, int value) {
  const auto [range, is_new] = ranges.try_emplace(key, value, value);
  if (is_new) return;
  range->second.first = std::min(range->second.first, value);
  range->second.second = std::max(range->second.second, value);
}

bool IsWithin(const std::map<int, std::pair<int, int>>& ranges, int key, int value) {
  const auto range = ranges.find(key);
  return range != ranges.end() && value > range->second.first && value < range->second.second;
}

}  // namespace

Footprint::Footprint(const Plane& plane, const OrientedPoints& points,
                     std::span<const std::uint32_t> members, double cell_m)
    : basis_(BasisFromZ(plane.normal)),
      origin_(points.points[members[0]].cast<double>()),
      pixel_m_(2 * cell_m) {
  for (std::uint32_t i : members) {
    const auto [column, row] = PixelOf(points.points[i].cast<double>());
    Extend(columns_of_row_, row, column);
    Extend(rows_of_column_, column, row);
    filled_.emplace(column, row);
  }
}

Footprint::Pixel Footprint::PixelOf(const Vector3& place) const {
  const Vector3 local = basis_.transpose() * (place - origin_) / pixel_m_;
  return {static_cast<int>(std::round(local.x())), static_cast<int>(std::round(local.y()))};
}

bool Footprint::Surrounds(const Vector3& place) const {
  const auto [column, row] = PixelOf(place);
  return IsWithin(columns_of_row_, row, column) && IsWithin(rows_of_column_, column, row);
}

bool Footprint::Covers(const Vector3& place) const {
  const auto [column, row] = PixelOf(place);
  for (int c = column - 1; c <= column + 1; ++c) {
    for (int r = row - 1; r <= row + 1; ++r) {
      if (!filled_.contains({c, r})) return false;
    }
  }
  return true;
}

bool Footprint::Touches(const Vector3& place) const {
  const auto [column, row] = PixelOf(place);
  for (int c = column - 1; c <= column + 1; ++c) {
    for (int r = row - 1; r <= row + 1; ++r) {
      if (filled_.contains({c, r})) return true;
    }
  }
  return false;
}

}  // namespace cwm::perception
