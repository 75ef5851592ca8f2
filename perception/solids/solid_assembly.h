// From fitted surfaces to the bounded solids of one object.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "perception/fit/extraction.h"
#include "perception/fit/solid.h"

namespace cwm::perception {

// chosen: caps the work on an object that is several things which touch, or on a face of several.
inline constexpr std::size_t kMaxParts = 5;

struct Assembly {
  std::vector<Solid> solids;
  std::vector<std::string> notes;
};

// Of a wall that no solid fills; it no longer holds for one that became a shell (shell_fit.h).
inline constexpr std::string_view kSeenFromBothSides =
    "a curved wall is seen from both sides: meshed, not filled";

// Whether more rays cross a solid than mixed pixels and a few outliers explain, of those to the
// object's own points or of those that passed it by.
bool IsCrossed(const Solid& solid, const FitContext& context);

// Round solids take their caps first, then boxes their faces, then what is left becomes thin
// solids. A solid that rays were seen to cross (a vessel with its inner wall in view) is refused:
// its points stay unexplained and are meshed.
Assembly AssembleSolids(const Extraction& extraction, const FitContext& context,
                        const Ground& ground);

}  // namespace cwm::perception
