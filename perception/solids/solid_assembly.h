// Assembles the bounded solids of one object from its fitted surfaces.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "perception/fit/extraction.h"
#include "perception/fit/solid.h"

namespace cwm::perception {

// chosen: bounds the work on an object that is several touching ones, or on a face shared by
// several.
inline constexpr std::size_t kMaxParts = 5;

struct Assembly {
  std::vector<Solid> solids;
  std::vector<std::string> notes;
};

// Note on a wall that no solid fills. It no longer holds for a wall that became a shell
// (shell_fit.h).
inline constexpr std::string_view kSeenFromBothSides =
    "a curved wall is seen from both sides: meshed, not filled";

// True if more rays cross a solid than mixed pixels and a few outliers explain, counting rays to
// the object's own points and rays that passed it. Without rays, true if points show too little of
// its surface.
bool IsCrossed(const Solid& solid, const FitContext& context);

// Builds round solids with their caps first, then boxes, then thin solids from the remaining faces.
// A round solid that rays cross (a vessel with its inner wall in view) is refused, and its points
// are meshed; the faces of a box that rays cross become thin solids.
Assembly AssembleSolids(const Extraction& extraction, const FitContext& context,
                        const Ground& ground);

}  // namespace cwm::perception
