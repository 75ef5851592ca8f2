// Tests which points of a scan the model explains, by their distances from it.
#pragma once

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

// True if the point lies within the tolerance (ExplainedWithin_m) of the surface of one of the
// shapes, tested from `likely` (an index, or negative) on. Points deep inside a solid do not count.
// Points and shapes are in the same frame.
bool IsNearAnyShape(const std::vector<ShapePart>& shapes, std::int32_t likely, const Vector3& point,
                    double tolerance_m);

}  // namespace cwm::perception
