// How much of a scan the model explains, measured against the model and not assumed.
#pragma once

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

// A point counts as explained within this distance of a collision surface; deep inside a solid is a
// miss.
inline double ExplainedWithin_m(double sigma_m) { return sigma_m > 0.01 / 3 ? 3 * sigma_m : 0.01; }

// Whether the point lies that near to the surface of one of the shapes, `likely` (an index, or
// negative) asked first. Points and shapes in one frame.
bool NearAnyShape(const std::vector<ShapePart>& shapes, std::int32_t likely, const Vector3& point,
                  double tolerance_m);

}  // namespace cwm::perception
