// Where whole solids end whose ends no point shows.
#pragma once

#include "perception/whole/whole_fit.h"
#include "perception/whole/whole_starts.h"

namespace cwm::perception {

// Moves the ends of a fit that nothing pulls at to where the points end: of boxes, of what lies,
// and of what leans far beyond its points. Its inliers stay as they are. The second argument are
// the points used, on the ground.
void EndWhereShown(const ModelPoints& points, const PointsOnGround& on_ground,
                   const ModelerOptions& options, WholeFit& fit);

}  // namespace cwm::perception
