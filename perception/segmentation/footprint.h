// What lies over or under a patch of a plane, and not beside it.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/plane_fit.h"

namespace cwm::perception {

// The pixels that points on a plane fill, seen along its normal: two cells wide, so that none stays
// empty for a cell that is found where its points' mean is.
class Footprint {
 public:
  // `cell_m` is the size of the points' cells. `members` must not be empty.
  Footprint(const Plane& plane, const OrientedPoints& points,
            std::span<const std::uint32_t> members, double cell_m);

  // Whether the foot of the perpendicular lies within the pixels of its row and of its column, and
  // in neither on the first or last: in holes too, not in notches.
  bool Surrounds(const Vector3& place) const;

  // Whether its pixel and all eight beside it are filled.
  bool Covers(const Vector3& place) const;

  // Whether its pixel or one beside it is.
  bool Touches(const Vector3& place) const;

  using Pixel = std::pair<int, int>;  // column, row
  Pixel PixelOf(const Vector3& place) const;
  double pixel_m() const { return pixel_m_; }

 private:
  using Range = std::pair<int, int>;

  Matrix3 basis_;  // columns: two axes in the plane, and its normal
  Vector3 origin_;
  double pixel_m_;
  std::map<int, Range> columns_of_row_, rows_of_column_;
  std::set<Pixel> filled_;
};

}  // namespace cwm::perception
