// The bounds of a support (paper, section III step 4): convex or not, with holes.
#pragma once

#include <vector>

#include "collision/geometry/shape.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_gaps.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

// chosen: a plate's thickness where only its top was seen.
inline constexpr double kPlateThickness_m = 0.02;

struct BoundedSupport {
  SupportPlane support;  // the cells that lie in the plate
  Placed<Plate> plate;
};

// The plates below a plane: within the hull of the nodes that were seen on it, all that is not
// known to be free.
//
// With `sight`, free is where rays pass through: they go on for more than the plate's thickness
// below its top. What is hidden behind something nearer and what returned nothing is support, so
// that things on the table and their shadows leave no hole.
// Without (`sight` null: nobody knows where the sensor was), free is what lies farther than
// kClosing_m from all that was seen; narrower gaps are closed.
//
// Free places narrower than three cells are taken for noise. A cell is half of a coarse cell (four
// standard deviations of the noise, at least 7.5 mm), more where the nodes are sparse. Where
// nothing is free the outline is the hull to half a cell, else it is true to one cell.
// At most kMaxOutlineCorners corners.
//
// Where free places part what was seen, each part large enough for a support of its own gets its
// plate, largest first; cells of smaller ones are in none. Empty when the nodes span no area. A
// plate's origin is in the middle of its outline, z along the plane's normal, x as near to the x of
// the nodes' frame as can be.
std::vector<BoundedSupport> BoundSupport(const SupportPlane& support, const CoarseCloud& coarse,
                                         const OrientedPoints& nodes, const SightMap* sight);

// Distance of a point's projection to the plate's border, metres: 0 or less on the plate, positive
// beyond its outline and in its holes.
double OutsideOutline_m(const Placed<Plate>& plate, const Vector3& point);

}  // namespace cwm::perception
