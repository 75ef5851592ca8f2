// Parts of one solid that an occluder separates in the view are one object.
#pragma once

#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/piece_views.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

// Joins two pieces when one plane (6 degrees, 3 sigma) or one cylinder explains a good part of
// both, and nothing that was seen contradicts that their surface continues from one to the other:
// every place between them lies behind something nearer, or on one of them. What is joined before,
// as vessels are, is whole: two of those stay two, for all floors of bowls on a table share a plane
// that the bowls' own walls hide. So do these floors and patches of the table: patches are joined
// to nothing here.
void JoinAcrossOccluders(const OrientedPoints& nodes, const PieceViews& views,
                         const SightMap& sight, DisjointSets& objects);

}  // namespace cwm::perception
