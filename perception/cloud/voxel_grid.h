// A fixed spatial decomposition of a cloud (paper, section IV): cells on sorted Morton keys with
// the sums of their points, for downsampling, centroids, covariances and neighbour lookup.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "perception/cloud/no_index.h"
#include "perception/cloud/work.h"

namespace cwm::perception {

// First and second moments of points about an origin that the owner defines.
struct Moments {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::array<float, 6> products{};  // sums of xx xy xz yy yz zz
  std::uint32_t count = 0;

  void Add(const Eigen::Vector3f& p) {
    sum += p;
    products[0] += p.x() * p.x();
    products[1] += p.x() * p.y();
    products[2] += p.x() * p.z();
    products[3] += p.y() * p.y();
    products[4] += p.y() * p.z();
    products[5] += p.z() * p.z();
    ++count;
  }
  // Adds moments about an origin that lies at `offset` from this one's.
  void Add(const Moments& other, const Eigen::Vector3f& offset);
  Eigen::Vector3f Mean() const { return sum / static_cast<float>(count); }
  Eigen::Matrix3f Covariance() const;  // about the mean; count must be positive
};

// Cells are ordered by Morton key, so that neighbours in space are mostly neighbours in memory;
// points within a cell keep their order. The 64 cells of an aligned block of 4 x 4 x 4 are
// consecutive in that order, so a lookup finds the block and then a bit for the cell.
class VoxelGrid {
 public:
  using Cell = Eigen::Vector3i;

  // derived: a block's cells are the bits of one word: 64 cells, 4 along each axis.
  static constexpr std::uint32_t kCellsOfBlock = std::numeric_limits<std::uint64_t>::digits;
  static constexpr int kBitsOfBlock = std::countr_zero(kCellsOfBlock);
  static constexpr int kBlockShift = kBitsOfBlock / 3;
  static constexpr int kBlockEdge = kCellsOfBlock >> (kBlockShift * 2);
  // derived: the block and the cell of a point fit in one number of 32 bits.
  static constexpr std::size_t kMaxPoints =
      std::size_t{1} << (std::numeric_limits<std::uint32_t>::digits - kBitsOfBlock);

  // Builds a grid of at most kMaxPoints finite points (else std::length_error). The edge is doubled
  // until the extent fits 2^21 cells per axis (4 mm cells: 8 km). The time is linear in the number
  // of points, however many are in one place.
  static VoxelGrid Build(std::span<const Eigen::Vector3f> points, float edge_m,
                         const Work& work = {});
  // The same without moments, for an owner who renumbers the points first.
  static VoxelGrid BuildCells(std::span<const Eigen::Vector3f> points, float edge_m,
                              const Work& work = {});

  std::size_t size() const { return cells_.size(); }  // occupied cells
  float edge_m() const { return edge_m_; }
  const Cell& cell(std::size_t i) const { return cells_[i]; }
  Eigen::Vector3f Center(std::size_t i) const;
  const Moments& moments(std::size_t i) const { return moments_[i]; }  // about Center(i)
  Eigen::Vector3f Centroid(std::size_t i) const { return Center(i) + moments_[i].Mean(); }
  std::span<const std::uint32_t> PointsOf(std::size_t i) const;
  std::uint32_t CellOfPoint(std::size_t point) const { return cell_of_point_[point]; }

  // Renumbers the points in the order of the cells. The owner then sorts its points the same way,
  // so that loops over cells run through memory in order. Returns the previous number of each
  // point.
  std::vector<std::uint32_t> Renumber();
  // Computes the moments. `points` are the points of the grid in its present numbering.
  void AccumulateMoments(std::span<const Eigen::Vector3f> points, const Work& work = {});

  // Calls f(index) for the occupied cells whose coordinates differ from these by at most `reach` on
  // every axis, including the cell itself, block by block. Stops, and returns true, once f returns
  // true.
  template <class F>
  bool AnyWithin(int reach, const Cell& cell, F&& f) const;
  // Calls f(index) for all of these cells; f returns nothing.
  template <class F>
  void ForEachWithin(int reach, const Cell& cell, F&& f) const;

  // Index of the occupied cell at these coordinates, or kNoIndex.
  std::int32_t Find(const Cell& cell) const;

 private:
  struct Block {
    std::uint64_t key = 0;
    std::uint64_t occupied = 0;  // one bit per cell, in Morton order
    std::uint32_t first = 0;     // index of its first cell

    std::size_t IndexOf(int bit) const {
      const std::uint64_t before = occupied & ((std::uint64_t{1} << bit) - 1);
      return first + static_cast<std::size_t>(std::popcount(before));
    }
  };

  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  float edge_m_ = 1;
  std::vector<Cell> cells_;
  std::vector<Moments> moments_;
  std::vector<std::uint32_t> first_;          // per cell and one more: its begin in order_
  std::vector<std::uint32_t> order_;          // points sorted by cell
  std::vector<std::uint32_t> cell_of_point_;  // per point
  std::vector<Block> blocks_;                 // sorted by key
  std::vector<std::int32_t> slots_;           // hash table of blocks, open addressing

  // The bits of the cells whose coordinates in the block are from low to high, all within 0 to 3.
  static std::uint64_t BitsBetween(const Cell& low, const Cell& high);
  // The block at these coordinates, which are those of its cells over 4; null if no cell of it is
  // occupied.
  const Block* FindBlock(const Cell& block) const;

  // The steps of building, in their order.
  void FindCells(std::span<const Eigen::Vector3f> points, const Work& work);
  void SortBlocks(const Work& work);
  void ListCells(std::size_t count);
  void SortPoints(const Work& work);
  std::uint32_t FindOrAddBlock(std::uint64_t key);
  std::size_t Slot(std::uint64_t key) const;
  void IndexBlocks();
};

template <class F>
bool VoxelGrid::AnyWithin(int reach, const Cell& cell, F&& f) const {
  const Cell low = cell.array() - reach, high = cell.array() + reach;
  const auto block_of = [](int coordinate) { return coordinate >> kBlockShift; };
  const Cell first = low.unaryExpr(block_of), last = high.unaryExpr(block_of);
  Cell b;
  for (b.z() = first.z(); b.z() <= last.z(); ++b.z()) {
    for (b.y() = first.y(); b.y() <= last.y(); ++b.y()) {
      for (b.x() = first.x(); b.x() <= last.x(); ++b.x()) {
        const Block* block = FindBlock(b);
        if (!block) continue;
        const Cell corner = b * kBlockEdge;
        std::uint64_t wanted = block->occupied;
        wanted &= BitsBetween((low - corner).cwiseMax(0), (high - corner).cwiseMin(kBlockEdge - 1));
        for (; wanted != 0; wanted &= wanted - 1) {
          if (f(block->IndexOf(std::countr_zero(wanted)))) return true;
        }
      }
    }
  }
  return false;
}

template <class F>
void VoxelGrid::ForEachWithin(int reach, const Cell& cell, F&& f) const {
  AnyWithin(reach, cell, [&](std::size_t other) {
    f(other);
    return false;
  });
}

}  // namespace cwm::perception
