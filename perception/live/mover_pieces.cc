#include "perception/live/mover_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>

namespace cwm::perception {
namespace {

// chosen: the smallest cell. With the margin a box then reaches at most 28 mm beyond a point.
constexpr double kSmallestCell_m = 0.018;
constexpr double kCellGrowth = 1.25;  // chosen: a tenth of the boxes less per step

using Cell = std::array<std::int32_t, 3>;  // z, y, x: ordered by rows of x
using Cells = std::map<Cell, int>;         // the number of points of each

bool HasNeighbour(const Cells& cells, const Cell& cell) {
  for (std::int32_t dz = -1; dz <= 1; ++dz) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dx = -1; dx <= 1; ++dx) {
        const bool is_itself = dz == 0 && dy == 0 && dx == 0;
        if (!is_itself && cells.contains({cell[0] + dz, cell[1] + dy, cell[2] + dx})) return true;
      }
    }
  }
  return false;
}

// Single points far from all others are noise at the outlines.
Cells WithoutStrays(const Cells& cells) {
  Cells kept;
  for (const auto& [cell, count] : cells) {
    if (count > 1 || HasNeighbour(cells, cell)) kept.emplace(cell, count);
  }
  return kept;
}

Cells CellsOf(const std::vector<Eigen::Vector3f>& points, const Vector3& origin_W, double edge_m) {
  Cells cells;
  for (const Eigen::Vector3f& p : points) {
    const Vector3 p_W = origin_W + p.cast<double>();
    Cell cell = {};
    for (int axis = 0; axis < 3; ++axis) {
      cell[static_cast<std::size_t>(2 - axis)] =
          static_cast<std::int32_t>(std::floor(p_W[axis] / edge_m));
    }
    ++cells[cell];
  }
  return points.size() > kLeastMoverPoints ? WithoutStrays(cells) : cells;
}

// The cells from low to high, both included.
struct Block {
  Cell low = {};
  Cell high = {};
};

// True if all cells of the layer beyond `block` along `axis` are there.
bool CanGrow(const Cells& cells, const Block& block, std::size_t axis) {
  Block layer = block;
  layer.low[axis] = layer.high[axis] = block.high[axis] + 1;
  for (std::int32_t z = layer.low[0]; z <= layer.high[0]; ++z) {
    for (std::int32_t y = layer.low[1]; y <= layer.high[1]; ++y) {
      for (std::int32_t x = layer.low[2]; x <= layer.high[2]; ++x) {
        if (!cells.contains({z, y, x})) return false;
      }
    }
  }
  return true;
}

// Divides the cells into blocks: the first cell left grows along x, y and z as far as it can.
std::vector<Block> JoinCells(Cells cells) {
  std::vector<Block> blocks;
  while (!cells.empty()) {
    Block block{cells.begin()->first, cells.begin()->first};
    for (const std::size_t axis : {2U, 1U, 0U}) {
      while (CanGrow(cells, block, axis)) ++block.high[axis];
    }
    for (std::int32_t z = block.low[0]; z <= block.high[0]; ++z) {
      for (std::int32_t y = block.low[1]; y <= block.high[1]; ++y) {
        for (std::int32_t x = block.low[2]; x <= block.high[2]; ++x) cells.erase({z, y, x});
      }
    }
    blocks.push_back(block);
  }
  return blocks;
}

Aabb BoxOf(const Block& block, double edge_m) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(2 - axis);
    box.min()[axis] = block.low[i] * edge_m - kMoverMargin_m;
    box.max()[axis] = (block.high[i] + 1) * edge_m + kMoverMargin_m;
  }
  return box;
}

}  // namespace

std::vector<MoverPiece> CoverByBoxes(std::span<const std::vector<Eigen::Vector3f>> lists,
                                     const Vector3& origin_W) {
  for (double edge_m = kSmallestCell_m;; edge_m *= kCellGrowth) {
    std::vector<MoverPiece> pieces;
    std::size_t boxes = 0;
    for (const std::vector<Eigen::Vector3f>& points : lists) {
      MoverPiece& piece = pieces.emplace_back();
      for (const Block& block : JoinCells(CellsOf(points, origin_W, edge_m))) {
        piece.boxes_W.push_back(BoxOf(block, edge_m));
      }
      boxes += piece.boxes_W.size();
    }
    std::erase_if(pieces, [](const MoverPiece& piece) { return piece.boxes_W.empty(); });
    // Lists without end cannot have less boxes than one each.
    if (boxes <= kMaxMoverBoxes) return pieces;
    if (lists.size() > kMaxMoverBoxes) lists = lists.first(kMaxMoverBoxes);
  }
}

double CoveredShare(std::span<const MoverPiece> pieces,
                    std::span<const std::vector<Eigen::Vector3f>> lists, const Vector3& origin_W) {
  std::int64_t all = 0;
  std::int64_t covered = 0;
  for (const std::vector<Eigen::Vector3f>& points : lists) {
    for (const Eigen::Vector3f& p : points) {
      const Vector3 p_W = origin_W + p.cast<double>();
      ++all;
      covered += std::ranges::any_of(pieces, [&](const MoverPiece& piece) {
        return std::ranges::any_of(piece.boxes_W,
                                   [&](const Aabb& box) { return box.contains(p_W); });
      });
    }
  }
  return all == 0 ? 1 : static_cast<double>(covered) / static_cast<double>(all);
}

double Volume_m3(std::span<const MoverPiece> pieces) {
  double volume_m3 = 0;
  for (const MoverPiece& piece : pieces) {
    for (const Aabb& box : piece.boxes_W) volume_m3 += box.volume();
  }
  return volume_m3;
}

}  // namespace cwm::perception
