// The error of time-of-flight cameras where surfaces light each other.
#pragma once

#include <vector>

#include "perception/simulation/range_image.h"

namespace cwm::perception {

// Per pixel by how much the measured range is too long, metres: light that reaches a surface by way
// of another one has gone farther, and the camera measures a mean weighted by brightness. One
// bounce between matt surfaces of albedo 0.5 under the camera's own light, nothing hidden from
// another; over patches of 16 x 16 pixels. Zero on surfaces that face no other; in a concave corner
// the walls move back and the edge itself does not, which rounds it.
std::vector<float> MultipathBias(const RangeImage& image, const PinholeCamera& camera);

}  // namespace cwm::perception
