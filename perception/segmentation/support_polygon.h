// The bounds of a support (paper, section III step 4): convex or not, possibly with holes.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_gaps.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

// chosen: a plate's thickness if only its top was seen.
inline constexpr double kPlateThickness_m = 0.02;

struct BoundedSupport {
  SupportPlane support;  // the cells that lie in the plate
  Placed<Plate> plate;
};

// Returns the plates of a plane: all places within the hull of the nodes seen on it that are not
// known to be free.
//
// With `sight`, a place is free if rays pass through it and continue for more than the plate's
// thickness below its top. Places that are hidden or gave no return are support, so that objects on
// a table and their shadows leave no holes.
// If `sight` is null (the sensor's place is unknown), places farther than kClosing_m from
// everything seen are free; narrower gaps are closed.
//
// Free places narrower than three cells count as noise. A cell is half of a coarse cell (four
// standard deviations of the noise, at least 7.5 mm), more where nodes are sparse. Without free
// places the outline is the hull to half a cell, else it is accurate to one cell. It has at most
// kMaxOutlineCorners corners.
//
// If free places divide what was seen, each part large enough for a support gets its own plate,
// largest first; cells of smaller parts are in none. Empty if the nodes span no area. A plate's
// origin is the middle of its outline, z is along the plane's normal and x as near as possible to x
// of the nodes' frame.
std::vector<BoundedSupport> BoundSupport(const SupportPlane& support, const CoarseCloud& coarse,
                                         const OrientedPoints& nodes, const SightMap* sight);

// Distance of a point's projection from the plate's border, in metres: zero or negative on the
// plate, positive outside its outline and in its holes.
double OutsideOutline_m(const Placed<Plate>& plate, const Vector3& point);

}  // namespace cwm::perception
