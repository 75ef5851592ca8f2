// Judges a known object without a detection by rays.
#pragma once

#include "perception/track/association.h"
#include "perception/track/range_view.h"

namespace cwm::perception {

// chosen: the least visible share of an object that may be judged; with less it counts as hidden.
inline constexpr double kMinVisibleShare = 0.15;

// Returns kKeep (seen, or out of view), kOcclude or kRemove.
Association::Outcome ClassifyByRays(const SightCounts& sights);

}  // namespace cwm::perception
