// From fitted surfaces to the bounded solids of one object.
#pragma once

#include <string>
#include <vector>

#include "perception/model/extraction.h"
#include "perception/model/solid.h"

namespace cwm::perception {

struct Assembly {
  std::vector<Solid> solids;
  std::vector<std::string> notes;
};

// Whether more rays cross a solid than mixed pixels and a few outliers explain.
bool IsCrossed(const Solid& solid, const FitContext& context);

// Round solids take their caps first, then boxes their faces, then what is left becomes thin
// solids. A solid that rays were seen to cross (a vessel with its inner wall in view) is refused:
// its points stay unexplained and are meshed.
Assembly AssembleSolids(const Extraction& extraction, const FitContext& context,
                        const Ground& ground);

}  // namespace cwm::perception
