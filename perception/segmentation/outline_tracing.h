// From a set of cells to the polygon around it.
#pragma once

#include <cstddef>
#include <vector>

#include "collision/geometry/polygon.h"
#include "perception/segmentation/cell_mask.h"

namespace cwm::perception {

// A border that runs counter-clockwise, and holes strictly inside that run clockwise.
struct Outline {
  Polygon border;
  std::vector<Polygon> holes;

  std::size_t corner_count() const;
};

// The outline of a set that hangs together by edges; coordinates in cells, the middle of cell
// (x, y) at (x, y). Midway between cells of the set and others, so that no two borders touch
// (marching squares, Lorensen and Cline 1987; where two cells of the set touch in a corner alone,
// they are parted). Empty when the set is empty.
Outline TraceOutline(const CellMask& mask);

// chosen: more corners than this have no use: an outline is simplified until they suffice.
inline constexpr std::size_t kMaxOutlineCorners = 64;

struct SimplifyLimits {
  double tolerance = 0;  // farthest that a dropped corner may lie from the outline
  std::size_t most_corners = kMaxOutlineCorners;
};

// With fewer corners (Douglas and Peucker 1973), simple again. When more corners than allowed
// remain, the tolerance grows by steps of half; when that does not help, the smallest holes and at
// last the concavities are given up.
Outline Simplified(Outline outline, const SimplifyLimits& limits);

}  // namespace cwm::perception
