// One object, modelled: the shapes and handles that explain its points.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// Index of a point's part: -1 unexplained, 0.. shape, and handles after them.
inline constexpr std::int32_t kUnexplained = -1;

// Handle::shape_index of a handle that begins at no shape, but at what is meshed.
inline constexpr int kNoShape = -1;

struct ObjectModel {
  std::vector<ShapePart> shapes;  // level frame: X_OS is X_LS here
  std::vector<Handle> handles;    // level frame too; without meshes
  // Per input point: shape index, shapes.size() + handle index, or kUnexplained.
  std::vector<std::int32_t> part_of_point;
  std::vector<std::string> notes;  // caps that fired, in words
};

}  // namespace cwm::perception
