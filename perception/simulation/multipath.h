// The multipath error of time-of-flight cameras, where surfaces light each other.
#pragma once

#include <vector>

#include "perception/simulation/range_image.h"

namespace cwm::perception {

// Per pixel, by how much the measured range is too long, in metres: light that reaches a surface by
// way of another one travels farther, and the camera measures a mean weighted by brightness. The
// model is one bounce between matt surfaces of albedo 0.5 under the camera's own light, without
// occlusion, over patches of 16 x 16 pixels. The bias is zero on surfaces that face no other. In a
// concave corner the walls move back and the edge does not, which rounds it.
std::vector<float> MultipathBias(const RangeImage& image, const PinholeCamera& camera);

}  // namespace cwm::perception
