// Finds level surfaces seen at a grazing angle by the height of the space that their points fill.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

using ReorientedCells = std::vector<std::uint32_t>;  // ascending

// Turns the normals of such cells to up. Seen along a board, few rows of an image show it, and
// noise along the ray is noise along the board: the window of a point's normal holds hardly more
// than one row, and the normal faces the sensor. But noise lifts no point off the board. A cell
// gets the normal of the level plane through it and its neighbours if its points fill less of its
// height than those of an upright surface would, and that plane is wider than noise in each
// direction. For clouds that were seen from one place. Returns the turned cells.
ReorientedCells ReorientLevelPatches(const Eigen::Vector3f& up, CoarseCloud& coarse,
                                     const Work& work);

// Gives points of turned cells the support's normal, if their cell is a support's and they are
// within noise of its plane. Points of turned cells that are no support's, such as small object
// tops, keep their normals.
void ReorientPointsOn(const std::vector<SupportPlane>& supports, const CoarseCloud& coarse,
                      const ReorientedCells& turned, OrientedPoints& points);

}  // namespace cwm::perception
