// What rays say about an object for which nothing was detected.
#pragma once

#include "perception/track/association.h"
#include "perception/track/range_view.h"

namespace cwm::perception {

// kKeep (seen, or out of view), kOcclude or kRemove.
Association::What JudgeByRays(const SightCounts& sights);

}  // namespace cwm::perception
