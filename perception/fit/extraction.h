// One shape after the other out of an object's points (paper, section V).
#pragma once

#include <string>
#include <vector>

#include "perception/fit/shape_fit.h"

namespace cwm::perception {

struct Extraction {
  std::vector<ShapeFit> fits;      // in the order in which they were taken, the best first
  std::vector<std::string> notes;  // caps that fired
};

// Searches, selects and takes away until no shape of min_inliers points is likely to be left. A
// shape takes with it what lies on it and beside its inliers whatever the normals say: edges are
// no shapes of their own.
Extraction ExtractShapes(const FitContext& context);

}  // namespace cwm::perception
