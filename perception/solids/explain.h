// Assigns measured points to solids, and measures how good the solids are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/work.h"
#include "perception/model/object_model.h"
#include "perception/search/model_points.h"

namespace cwm::perception {

// A point within this distance of a solid's surface, or within 3 sigma if that is more, belongs to
// the solid whatever its normal is. This is stricter than the distance within which a point counts
// as explained (ExplainedWithin_m, 10 mm): points between the two are left for handles and
// surfaces, which may follow them better, and the solid explains those that are still left.
// derived: noise spreads no farther.
inline constexpr double kMinAssignmentTolerance_m = kNoiseReach_m;
inline double AssignmentTolerance_m(float sigma_m) {
  return std::max(kMinAssignmentTolerance_m, kDistanceGate_sigma * double{sigma_m});
}

// Returns for each point the index of the solid with the nearest surface within reach, else
// kUnexplained.
std::vector<std::int32_t> ExplainPoints(const OrientedPoints& points,
                                        const std::vector<ShapePart>& solids, const Work& work);

// Measures the fit quality of each solid from the points assigned to it; parameter_sigma stays as
// it is.
void MeasureQuality(const OrientedPoints& points, const std::vector<std::int32_t>& part_of_point,
                    double spacing_m, std::vector<ShapePart>& solids, const Work& work);

}  // namespace cwm::perception
