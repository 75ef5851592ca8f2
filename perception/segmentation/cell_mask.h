// Sets of raster cells, with morphological closing and opening and connected components.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/cloud/no_index.h"

namespace cwm::perception {

// Row-major: cell (x, y) is in column x of row y. No cell outside the raster is in the set.
struct CellMask {
  int width = 0;
  int height = 0;
  std::vector<char> on;

  static CellMask Empty(int width, int height) {
    return {width, height,
            std::vector<char>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
  }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  bool Has(int x, int y) const {
    return x >= 0 && y >= 0 && x < width && y < height && on[Index(x, y)] != 0;
  }
};

// The mask without the places that no square of 2 reach + 1 cells fits into.
CellMask Opened(const CellMask& mask, int reach);

// The mask with the free places that no square of 2 reach + 1 cells fits into: gaps of up to 2
// reach cells close. The raster's border counts as free space.
CellMask Closed(const CellMask& mask, int reach);

// Sets of cells that are connected by their edges, numbered from 0 in the order of their first
// cells; kNoIndex for cells that are off.
struct Components {
  std::vector<std::int32_t> of_cell;
  std::int32_t count = 0;
};
Components ComponentsOf(const CellMask& mask);

}  // namespace cwm::perception
