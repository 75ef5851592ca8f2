// The model of one object: the shapes and handles that explain its points.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// chosen: the part index of a point that no part explains. Shapes have the indices from 0, and
// handles follow them.
inline constexpr std::int32_t kUnexplained = -1;

// derived: Handle::shape_index of a handle that begins at a meshed surface rather than a shape.
inline constexpr int kNoShape = kUnexplained;

struct ObjectModel {
  std::vector<ShapePart> shapes;  // in the level frame: X_OS is X_LS here
  std::vector<Handle> handles;    // also in the level frame; without meshes
  // The part of each input point: a shape index, shapes.size() + handle index, or kUnexplained.
  std::vector<std::int32_t> part_of_point;
  std::vector<std::string> notes;  // limits that were reached, in words
};

}  // namespace cwm::perception
