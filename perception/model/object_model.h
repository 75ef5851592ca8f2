// One object, modelled: the shapes and handles that explain its points.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// chosen: index of a point's part where it has none; 0.. is a shape, and handles follow them.
inline constexpr std::int32_t kUnexplained = -1;

// derived: Handle::shape_index of a handle that begins at no shape, but at what is meshed.
inline constexpr int kNoShape = kUnexplained;

struct ObjectModel {
  std::vector<ShapePart> shapes;  // level frame: X_OS is X_LS here
  std::vector<Handle> handles;    // level frame too; without meshes
  // Per input point: shape index, shapes.size() + handle index, or kUnexplained.
  std::vector<std::int32_t> part_of_point;
  std::vector<std::string> notes;  // caps that fired, in words
};

}  // namespace cwm::perception
