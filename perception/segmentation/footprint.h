// The footprint of a patch of a plane, to tell places over or under it from places beside it.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "perception/cloud/oriented_points.h"
#include "perception/segmentation/plane_fit.h"

namespace cwm::perception {

// The pixels that points on a plane fill, seen along its normal. A pixel is two cells wide, so that
// none stays empty only because a cell counts at the mean of its points.
class Footprint {
 public:
  // `cell_m` is the size of the points' cells. `members` must not be empty.
  Footprint(const Plane& plane, const OrientedPoints& points,
            std::span<const std::uint32_t> members, double cell_m);

  // True if the foot of the perpendicular lies strictly between the first and the last filled pixel
  // of its row, and of its column. That includes holes but not notches.
  bool Surrounds(const Vector3& place) const;

  // True if the place's pixel and its eight neighbours are filled.
  bool Covers(const Vector3& place) const;

  // True if the place's pixel or one of its eight neighbours is filled.
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
