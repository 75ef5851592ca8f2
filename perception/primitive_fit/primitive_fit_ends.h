// Ends of fitted solids that no point constrains.
#pragma once

#include "perception/primitive_fit/primitive_fit.h"
#include "perception/primitive_fit/primitive_fit_starts.h"

namespace cwm::perception {

// Moves unconstrained ends of a fit to where its inliers end: of boxes, of lying solids, and of
// leaning ones whose upper end is far beyond their points. The inliers stay as they are.
// `on_ground` holds the points that were used for the fit, in the frame of the ground.
void SetFreeEnds(const ModelPoints& points, const PointsOnGround& on_ground,
                 const ModelerOptions& options, PrimitiveFit& fit);

}  // namespace cwm::perception
