// Distances of a body link by link (DistancePairs::kLinks).
#pragma once

#include <memory>

#include "collision/query/body_search.h"
#include "collision/query/pair_rows.h"
#include "collision/query/query.h"

namespace cwm::collision {

// `tie_m` is as for NearestPair. The search outlives the finder.
std::unique_ptr<RowFinder> MakeLinkPairFinder(BodySearch& search, const QueryOptions& options,
                                              double tie_m);

}  // namespace cwm::collision
