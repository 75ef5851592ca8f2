// Which measured point belongs to which solid, and how good the solids are.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/model/object_modeler.h"

namespace cwm::perception {

// A point within this of a solid's surface, or within 3 sigma where that is more, is explained by
// it whatever its normal says (half of what a collision surface may be off).
inline constexpr double kExplained_m = 0.006;

// Per point the index of the solid whose surface is nearest and near enough, else kUnexplained.
std::vector<std::int32_t> ExplainPoints(const OrientedPoints& points,
                                        const std::vector<ShapePart>& solids);

// Quality of each solid from the points that it explains; parameter_sigma is left as it is.
void MeasureQuality(const OrientedPoints& points, const std::vector<std::int32_t>& part_of_point,
                    double spacing_m, std::vector<ShapePart>& solids);

}  // namespace cwm::perception
