// Inner wall, outer wall and floor of a vessel are one object.
#pragma once

#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/piece_views.h"

namespace cwm::perception {

// Joins pieces that share a vertical axis of revolution with a wall seen from inside, and what lies
// level within that wall.
void JoinVessels(const OrientedPoints& nodes, const PieceViews& views, DisjointSets& objects);

}  // namespace cwm::perception
