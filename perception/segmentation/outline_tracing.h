// Traces the polygon around a set of cells.
#pragma once

#include <cstddef>
#include <vector>

#include "collision/geometry/polygon.h"
#include "perception/segmentation/cell_mask.h"

namespace cwm::perception {

// A border that runs counter-clockwise, and holes strictly inside it that run clockwise.
struct Outline {
  Polygon border;
  std::vector<Polygon> holes;

  std::size_t corner_count() const;
};

// Traces the outline of a set of cells that is connected by edges, in units of cells with the
// middle of cell (x, y) at (x, y). It runs midway between cells of the set and others, so that no
// two borders touch (marching squares, Lorensen and Cline 1987; two cells of the set that only
// share a corner are separated). Empty if the set is empty.
Outline TraceOutline(const CellMask& mask);

// chosen: more corners are of no use; outlines are simplified until they have no more.
inline constexpr std::size_t kMaxOutlineCorners = 64;

struct SimplifyLimits {
  double tolerance = 0;  // the largest distance of a dropped corner from the outline
  std::size_t max_corners = kMaxOutlineCorners;
};

// Returns the outline with fewer corners (Douglas and Peucker 1973) and without crossings. If the
// result is not valid, the tolerance is halved twice, as borders may cross, and then grows by half
// per step, as corners may be too many. If that does not suffice, the smallest holes are dropped,
// and at last all concavities.
Outline Simplified(Outline outline, const SimplifyLimits& limits);

}  // namespace cwm::perception
