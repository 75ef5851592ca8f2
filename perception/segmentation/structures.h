// Walls, fronts and sides of furniture: large planes that support nothing and belong to no object
// (the overall geometry for collision; paper, contributions in section I).
#pragma once

#include <cstdint>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

struct Structures {
  std::vector<std::int32_t> of_piece;  // per piece: an index into planes, or kNoIndex
  std::vector<Plane> planes;           // normals on the side that was seen
};

// A piece is a structure if nearly all of it lies on one plane that reaches farther than any
// tabletop object; the rest are handles and edges. Other pieces on that plane, such as a wall
// between objects before it, belong to the same structure if the gap between them is hidden
// (IsGapClosed). The front of a box in the plane of a wall is not part of it if rays pass between
// them. Supports are never structures.
Structures FindStructures(const SurfaceGraph& graph, const Pieces& pieces, const SightMap& sight);

}  // namespace cwm::perception
