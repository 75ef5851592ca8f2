// Turns pieces into objects: which connected regions stand on a support (paper, section IV, figure
// 5), which objects they consist of, and what is left over.
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
  std::int32_t rests_on = -1;      // the segment between it and the support, or -1
  double foot_height_m = 0;        // the height of its foot above the support's top
  bool is_hanging = false;         // rays pass below its foot: the support does not carry it
  std::optional<Plane> plane = std::nullopt;  // of a wall or front
};

struct Regions {
  std::vector<Segment> segments;        // objects, largest first, then residuals, largest first
  std::vector<std::uint32_t> rejected;  // nodes that belong to nothing
};

// Each piece is one object (JoinPieces). Pieces below a support, such as its own front, are not
// part of a region above it. A region of linked pieces stands on the support if all of these hold:
//   - It lies over the support in one of these ways:
//       - most of it lies over the support's outline;
//       - a part of it does, none of it is lower, and it reaches out of the view;
//       - a part of it does, none of it is lower, its own shadow cuts the support off, and no ray
//         passes right below its foot;
//       - it lies beside what was seen of the support, and its foot and all places from there to
//         the support are hidden.
//   - It reaches down to the support, or its foot is hidden, or it is a ball that touches the
//     support and lies mostly over the outline.
//   - Its footprint on the support's cells is at least kMinObjectArea_m2.
// A region also stands on a support if it rests on objects that do (AssignSupportsUnderStacks).
// Every other region of linked pieces becomes one residual, and so does every wall or front
// (FindStructures), which is part of no region. Objects that rest on others are marked
// (AssignResting). Nodes in no piece are rejected up to 0.5 % of the points; beyond that, the
// larger groups of them become residuals too.
Regions FormRegions(const SurfaceGraph& graph, const CoarseCloud& coarse, const Pieces& pieces,
                    const std::vector<SupportPlane>& supports,
                    const std::vector<Placed<Plate>>& plates, const SightMap& sight,
                    const Work& work = {});

// Merges all objects on one support into one segment. Residuals stay as they are.
void MergeOnSupports(Regions& regions);

}  // namespace cwm::perception
