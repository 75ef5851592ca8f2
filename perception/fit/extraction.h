// Extracts one shape after the other from an object's points (paper, section V).
#pragma once

#include <string>
#include <vector>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

struct Extraction {
  std::vector<ShapeFit> fits;      // in the order of extraction, the best first
  std::vector<std::string> notes;  // limits that were reached
};

// Searches for a shape, selects its model and removes its points, until no shape of min_inliers
// points is likely to be left. A shape also takes the points that lie on it beside its inliers
// whatever their normals are, since edges are no shapes of their own.
Extraction ExtractShapes(const FitContext& context);

}  // namespace cwm::perception
