#include "perception/segmentation/cell_mask.h"

#include <algorithm>
#include <utility>

namespace cwm::perception {
namespace {

// Turns a cell of a line on if any cell within `reach` of it is on. Cells of the line are `stride`
// apart.
void SpreadLine(const char* from, char* to, int count, std::size_t stride, int reach) {
  int last_on = -reach - 1;  // the latest cell that is on, up to k + reach
  const auto at = [stride](int k) { return static_cast<std::size_t>(k) * stride; };
  for (int k = 0; k < std::min(reach, count); ++k) {
    if (from[at(k)] != 0) last_on = k;
  }
  for (int k = 0; k < count; ++k) {
    if (k + reach < count && from[at(k + reach)] != 0) last_on = k + reach;
    to[at(k)] = last_on >= k - reach;
  }
}

CellMask Dilated(const CellMask& mask, int reach) {
  CellMask along_rows = mask, out = mask;
  for (int y = 0; y < mask.height; ++y) {
    SpreadLine(&mask.on[mask.Index(0, y)], &along_rows.on[mask.Index(0, y)], mask.width, 1, reach);
  }
  const auto stride = static_cast<std::size_t>(mask.width);
  for (int x = 0; x < mask.width; ++x) {
    SpreadLine(&along_rows.on[mask.Index(x, 0)], &out.on[mask.Index(x, 0)], mask.height, stride,
               reach);
  }
  return out;
}

CellMask Complement(CellMask mask) {
  for (char& on : mask.on) on = on == 0;
  return mask;
}

// The mask in a raster that is wider by `reach` on all sides, so that cells beyond the border are
// free.
CellMask Padded(const CellMask& mask, int reach) {
  CellMask out = CellMask::Empty(mask.width + 2 * reach, mask.height + 2 * reach);
  for (int y = 0; y < mask.height; ++y) {
    const auto row = mask.on.begin() + static_cast<std::ptrdiff_t>(mask.Index(0, y));
    std::copy(row, row + mask.width,
              out.on.begin() + static_cast<std::ptrdiff_t>(out.Index(reach, y + reach)));
  }
  return out;
}

CellMask Unpadded(const CellMask& mask, int reach) {
  CellMask out = CellMask::Empty(mask.width - 2 * reach, mask.height - 2 * reach);
  for (int y = 0; y < out.height; ++y) {
    const auto row = mask.on.begin() + static_cast<std::ptrdiff_t>(mask.Index(reach, y + reach));
    std::copy(row, row + out.width, out.on.begin() + static_cast<std::ptrdiff_t>(out.Index(0, y)));
  }
  return out;
}

CellMask Eroded(const CellMask& mask, int reach) {
  return Complement(Dilated(Complement(mask), reach));
}

}  // namespace

CellMask Opened(const CellMask& mask, int reach) {
  return Unpadded(Dilated(Eroded(Padded(mask, reach), reach), reach), reach);
}

CellMask Closed(const CellMask& mask, int reach) {
  return Unpadded(Eroded(Dilated(Padded(mask, reach), reach), reach), reach);
}

Components ComponentsOf(const CellMask& mask) {
  Components out{std::vector<std::int32_t>(mask.on.size(), kNoIndex), 0};
  std::vector<std::pair<int, int>> front;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (!mask.Has(x, y) || out.of_cell[mask.Index(x, y)] != kNoIndex) continue;
      const std::int32_t number = out.count++;
      out.of_cell[mask.Index(x, y)] = number;
      front.assign(1, {x, y});
      while (!front.empty()) {
        const auto [u, v] = front.back();
        front.pop_back();
        constexpr int kSides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        for (const auto& d : kSides) {
          const int i = u + d[0], j = v + d[1];
          if (!mask.Has(i, j) || out.of_cell[mask.Index(i, j)] != kNoIndex) {
            continue;
          }
          out.of_cell[mask.Index(i, j)] = number;
          front.emplace_back(i, j);
        }
      }
    }
  }
  return out;
}

}  // namespace cwm::perception
