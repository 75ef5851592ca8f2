// Joins the inner wall, outer wall and floor of a vessel.
#pragma once

#include "perception/segmentation/disjoint_sets.h"
#include "perception/segmentation/piece_summaries.h"

namespace cwm::perception {

// Joins walls that share a vertical axis of revolution and touch or are the two sides of one wall.
// If one of them shows the inside, also joins the floor and the scraps within it.
void JoinVessels(const OrientedPoints& nodes, const PieceSummaries& views, DisjointSets& objects);

}  // namespace cwm::perception
