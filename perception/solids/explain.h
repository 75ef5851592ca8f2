// Which measured point belongs to which solid, and how good the solids are.
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

// A point within this of a solid's surface, or within 3 sigma where that is more, belongs to it
// whatever its normal says. Stricter than what counts as explained (ExplainedWithin_m, 10 mm): what
// lies between is left for handles and surfaces, which would follow it better, and is explained by
// the solid only where they do not.
// derived: noise spreads no farther.
inline constexpr double kBelongs_m = kNoiseReach_m;
inline double BelongsWithin_m(float sigma_m) {
  return std::max(kBelongs_m, kDistanceGate_sigma * double{sigma_m});
}

// Per point the index of the solid whose surface is nearest and near enough, else kUnexplained.
std::vector<std::int32_t> ExplainPoints(const OrientedPoints& points,
                                        const std::vector<ShapePart>& solids, const Work& work);

// Quality of each solid from the points that it explains; parameter_sigma is left as it is.
void MeasureQuality(const OrientedPoints& points, const std::vector<std::int32_t>& part_of_point,
                    double spacing_m, std::vector<ShapePart>& solids, const Work& work);

}  // namespace cwm::perception
