// Joins parts of one solid that an occluder separates in the view.
#pragma once

#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/piece_summaries.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// Joins two pieces if one plane (6 degrees, 3 sigma) or one cylinder explains a good part of both,
// and their surface may continue between them: at most 6 % of the places between them are seen
// through, and at least 25 % are hidden. Pieces with a common plane that are in contact are joined
// without that test. Sets that were joined before, such as vessels, are complete, and two of them
// are never joined: the floors of all bowls on a table share a plane that the bowls' walls hide.
// The same holds for these floors and patches of the table, so patches are not joined here.
void JoinAcrossOccluders(const OrientedPoints& nodes, const PieceSummaries& views,
                         const SightMap& sight, DisjointSets& objects);

}  // namespace cwm::perception
