// Level surfaces that are seen at a grazing angle, told by the room that their points fill.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/work.h"
#include "perception/segmentation/support_planes.h"

namespace cwm::perception {

using TurnedCells = std::vector<std::uint32_t>;  // ascending

// Where one looks along a board, few rows of an image show it, and noise along the ray is noise
// along the board: the window of a point's normal holds hardly more than one row, and its normal
// faces the sensor. But noise lifts no point off the board. A cell whose points fill less of its
// height than those of what stands do, and make with those around a level plane wider than noise
// each way, gets the normal of that plane. For clouds that were seen from one place. Returns the
// cells that it turned.
TurnedCells TurnLevelPatches(const Eigen::Vector3f& up, CoarseCloud& coarse, const Work& work);

// Of the cells that were turned, those of supports: their points within noise of the support get
// its normal too. Of what is small, as the tops of things are, points keep what they have.
void TurnPointsOn(const std::vector<SupportPlane>& supports, const CoarseCloud& coarse,
                  const TurnedCells& turned, OrientedPoints& points);

}  // namespace cwm::perception
