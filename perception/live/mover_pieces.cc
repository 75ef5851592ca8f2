#include "perception/live/mover_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: the smallest cell. With the margin a box then reaches at most 28 mm beyond a point.
constexpr double kSmallestCell_m = 0.018;
// Larger cells are made of the middles of the smallest ones: their points are within the margin.
static_assert(kSmallestCell_m / 2 <= kMoverMargin_m);

using Cell = std::array<std::int32_t, 3>;  // z, y, x: ordered by rows of x

std::uint64_t KeyOf(const Cell& cell) {
  constexpr std::uint64_t kBits = 21;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
  std::uint64_t key = 0;
  for (const std::int32_t value : cell) {
    key = key << kBits | (static_cast<std::uint64_t>(value) & kMask);
  }
  return key;
}

Cell CellAt(const Vector3& p_W, double edge_m) {
  Cell cell = {};
  for (int axis = 0; axis < 3; ++axis) {
    cell[static_cast<std::size_t>(2 - axis)] =
        static_cast<std::int32_t>(std::floor(p_W[axis] / edge_m));
  }
  return cell;
}

Vector3 MiddleOf(const Cell& cell, double edge_m) {
  return edge_m * Vector3(cell[2] + 0.5, cell[1] + 0.5, cell[0] + 0.5);
}

void SortUnique(std::vector<Cell>& cells) {
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

bool HasNeighbour(const absl::flat_hash_map<std::uint64_t, int>& counts, const Cell& cell) {
  for (std::int32_t dz = -1; dz <= 1; ++dz) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dx = -1; dx <= 1; ++dx) {
        const bool is_itself = dz == 0 && dy == 0 && dx == 0;
        if (!is_itself && counts.contains(KeyOf({cell[0] + dz, cell[1] + dy, cell[2] + dx}))) {
          return true;
        }
      }
    }
  }
  return false;
}

// The smallest cells of the points, ordered. Single points far from all others are noise at the
// outlines.
std::vector<Cell> SmallestCells(const std::vector<Eigen::Vector3f>& points,
                                const Vector3& origin_W) {
  std::vector<Cell> cells;
  absl::flat_hash_map<std::uint64_t, int> counts;
  for (const Eigen::Vector3f& p : points) {
    const Cell cell = CellAt(origin_W + p.cast<double>(), kSmallestCell_m);
    if (++counts[KeyOf(cell)] == 1) cells.push_back(cell);
  }
  if (points.size() > kMinMoverPoints) {
    std::vector<Cell> kept;
    std::ranges::copy_if(cells, std::back_inserter(kept), [&](const Cell& cell) {
      return counts.at(KeyOf(cell)) > 1 || HasNeighbour(counts, cell);
    });
    // Far away all points are farther apart than cells.
    const auto strays = static_cast<double>(cells.size() - kept.size());
    if (strays < kMinSignificantShare * static_cast<double>(cells.size())) cells = std::move(kept);
  }
  SortUnique(cells);
  return cells;
}

std::vector<Cell> LargerCells(const std::vector<Cell>& smallest, double edge_m) {
  std::vector<Cell> cells;
  cells.reserve(smallest.size());
  for (const Cell& cell : smallest)
    cells.push_back(CellAt(MiddleOf(cell, kSmallestCell_m), edge_m));
  SortUnique(cells);
  return cells;
}

// The cells from low to high, both included.
struct Block {
  Cell low = {};
  Cell high = {};
};

using CellSet = absl::flat_hash_set<std::uint64_t>;

// Calls visit(cell) for the cells of the block until it returns false. True if it never did.
template <class Visit>
bool ForCells(const Block& block, const Visit& visit) {
  for (std::int32_t z = block.low[0]; z <= block.high[0]; ++z) {
    for (std::int32_t y = block.low[1]; y <= block.high[1]; ++y) {
      for (std::int32_t x = block.low[2]; x <= block.high[2]; ++x) {
        if (!visit(Cell{z, y, x})) return false;
      }
    }
  }
  return true;
}

// True if all cells of the layer beyond `block` along `axis` are there.
bool CanGrow(const CellSet& left, const Block& block, std::size_t axis) {
  Block layer = block;
  layer.low[axis] = layer.high[axis] = block.high[axis] + 1;
  return ForCells(layer, [&](const Cell& cell) { return left.contains(KeyOf(cell)); });
}

// Divides the ordered cells into blocks: the first cell left grows along x, y and z as far as it
// can.
std::vector<Block> JoinCells(const std::vector<Cell>& cells) {
  CellSet left;
  left.reserve(cells.size());
  for (const Cell& cell : cells) left.insert(KeyOf(cell));
  std::vector<Block> blocks;
  for (const Cell& first : cells) {
    if (!left.contains(KeyOf(first))) continue;
    Block block{first, first};
    for (const std::size_t axis : {2U, 1U, 0U}) {
      while (CanGrow(left, block, axis)) ++block.high[axis];
    }
    ForCells(block, [&](const Cell& cell) {
      left.erase(KeyOf(cell));
      return true;
    });
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
  std::vector<std::vector<Cell>> smallest;
  for (const std::vector<Eigen::Vector3f>& points : lists) {
    std::vector<Cell> cells = SmallestCells(points, origin_W);
    if (cells.empty()) continue;
    // Each piece has a box at least: the last one takes what further lists have.
    if (smallest.size() == kMaxMoverBoxes) {
      smallest.back().insert(smallest.back().end(), cells.begin(), cells.end());
      SortUnique(smallest.back());
    } else {
      smallest.push_back(std::move(cells));
    }
  }
  for (double edge_m = kSmallestCell_m;;) {
    std::vector<MoverPiece> pieces(smallest.size());
    double boxes = 0;
    for (std::size_t i = 0; i < smallest.size(); ++i) {
      const bool is_smallest = edge_m == kSmallestCell_m;
      for (const Block& block :
           JoinCells(is_smallest ? smallest[i] : LargerCells(smallest[i], edge_m))) {
        pieces[i].boxes_W.push_back(BoxOf(block, edge_m));
        ++boxes;
      }
    }
    if (boxes <= kMaxMoverBoxes) return pieces;
    // derived: a surface has as many boxes as cells have room on it; joined cells make it less.
    edge_m *= std::clamp(std::sqrt(boxes / kMaxMoverBoxes), 1.1, 2.0);
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
