// From pieces to things: which connected regions stand on a support (paper, section IV, figure 5),
// which objects they consist of, and what is left over.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/sight_map.h"
#include "perception/segmentation/support_polygon.h"

namespace cwm::perception {

// Everything that is not a support. Nodes ascending.
struct Segment {
  std::vector<std::uint32_t> nodes;
  std::int32_t supported_by = -1;  // the support below; -1: residual geometry
  std::int32_t rests_on = -1;      // index into segments: what is between it and the support, or -1
  double foot_height_m = 0;        // of where it rests, above the support's top
  bool hangs = false;              // one sees below its foot: the support does not carry it itself
  std::optional<Plane> plane = std::nullopt;  // of a wall or front
};

struct Regions {
  std::vector<Segment> segments;        // objects, largest first, then residuals, largest first
  std::vector<std::uint32_t> rejected;  // nodes that belong to nothing
};

// Each piece is one object (JoinPieces). A region of linked pieces, less those that lie below the
// support as its own front does, stands on it when most of it lies over the support's outline (of
// one that reaches out of the view, a part of it, and nothing of it is lower; at an edge that its
// own shadow cuts off, a part of it, and no ray passes right below its foot; or beside it, where
// its foot and all from there to what was seen of the support are hidden), it reaches down to it,
// its foot is hidden or it is a ball that touches it, and its footprint on the support's cells is
// at least kMinThing_m2; or when it rests on objects that do (FindSupportsUnderStacks).
// Linked pieces that stand on nothing become one residual each, and so does each wall or front
// (FindStructures), which is part of no region. Objects that rest on others say so
// (FindWhatTheyRestOn). Nodes in no piece are rejected as long as they are at most 0.5 % of the
// points; beyond that the larger sets of them become residuals too.
Regions FormRegions(const SurfaceGraph& graph, const CoarseCloud& coarse, const Pieces& pieces,
                    const std::vector<SupportPlane>& supports,
                    const std::vector<Placed<Plate>>& plates, const SightMap& sight,
                    const Work& work = {});

// All that stands on one support becomes one segment. Residuals stay as they are.
void MergeOnSupports(Regions& regions);

}  // namespace cwm::perception
