// How much of a scan the model explains, measured against the model and not assumed.
#pragma once

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

// Whether the point lies within the tolerance (ExplainedWithin_m) of the surface of one of the
// shapes, `likely` (an index, or negative) asked first; deep inside a solid is a miss. Points and
// shapes in one frame.
bool NearAnyShape(const std::vector<ShapePart>& shapes, std::int32_t likely, const Vector3& point,
                  double tolerance_m);

}  // namespace cwm::perception
