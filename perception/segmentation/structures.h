// Walls, fronts and sides of furniture: large planes that support nothing and belong to no object
// (the overall geometry for collision, paper, contributions of section I).
#pragma once

#include <cstdint>
#include <vector>

#include "perception/segmentation/pieces.h"
#include "perception/segmentation/plane_fit.h"
#include "perception/segmentation/sight_map.h"

namespace cwm::perception {

struct Structures {
  std::vector<std::int32_t> of_piece;  // per piece: an index into planes, or kNoIndex
  std::vector<Plane> planes;           // normals to the side that was seen
};

// A piece is a structure when nearly all of it is one plane that reaches farther than anything on a
// table does; the rest are handles and edges. Pieces that lie on its plane, as a wall between the
// things before it does, belong to the same one where what is between them is hidden (GapIsClosed):
// the front of a box in the plane of a wall that one sees past is none of it. Supports are never
// structures.
Structures FindStructures(const SurfaceGraph& graph, const Pieces& pieces, const SightMap& sight);

}  // namespace cwm::perception
