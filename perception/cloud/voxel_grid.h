// One fixed spatial decomposition of a cloud (paper, section IV): cells on sorted Morton keys with
// the sums of their points, which serve downsampling, centroids, covariances and neighbour lookup.
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

// First and second moments of points about an origin that the owner states.
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
  // Adds moments that were taken about an origin that lies at `offset` from this one's.
  void Add(const Moments& other, const Eigen::Vector3f& offset);
  Eigen::Vector3f Mean() const { return sum / static_cast<float>(count); }
  Eigen::Matrix3f Covariance() const;  // about the mean; count must be positive
};

// Cells are ordered by Morton key, so that neighbours in space are mostly neighbours in memory, and
// points within a cell keep their order. The 64 cells of an aligned block of 4 x 4 x 4 follow each
// other in that order: what is looked up is the block, and a bit for each of its cells tells the rest.
class VoxelGrid {
 public:
  using Cell = Eigen::Vector3i;

  // derived: of a block, whose cells are the bits of one word: 64, and 4 along each axis.
  static constexpr std::uint32_t kCellsOfBlock = std::numeric_limits<std::uint64_t>::digits;
  static constexpr int kBitsOfBlock = std::countr_zero(kCellsOfBlock);
  static constexpr int kBlockShift = kBitsOfBlock / 3;
  static constexpr int kBlockEdge = kCellsOfBlock >> (kBlockShift * 2);
  // derived: block and cell of a point are one number of 32 bits.
  static constexpr std::size_t kMaxPoints =
      std::size_t{1} << (std::numeric_limits<std::uint32_t>::digits - kBitsOfBlock);

  // All points must be finite, and kMaxPoints at most (std::length_error). The edge is doubled
  // until the extent fits 2^21 cells per axis (4 mm cells: 8 km). Linear time in the points,
  // however many share one place.
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

  // Numbers the points anew, in the order of the cells: for the owner who brings them into it, so
  // that loops over cells run through memory in order. Returns the number that each one had.
  std::vector<std::uint32_t> Renumber();
  // Makes the moments. `points` are those of the grid, numbered as it numbers them now.
  void SumUp(std::span<const Eigen::Vector3f> points, const Work& work = {});

  // f(index) for the occupied cells whose coordinates differ from these by at most `reach` on every
  // axis, the middle one among them, block by block. Ends early, and is true, once f returns true.
  template <class F>
  bool AnyWithin(int reach, const Cell& cell, F&& f) const;
  // The same for all of them; f returns nothing.
  template <class F>
  void ForEachWithin(int reach, const Cell& cell, F&& f) const;

  // Index of the occupied cell at these coordinates, or kNoIndex.
  std::int32_t Find(const Cell& cell) const;

 private:
  struct Block {
    std::uint64_t key = 0;
    std::uint64_t occupied = 0;  // a bit for each cell, in the order of Morton keys
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
  std::vector<std::uint32_t> first_;          // per cell and one more: where its points begin
  std::vector<std::uint32_t> order_;          // points sorted by cell
  std::vector<std::uint32_t> cell_of_point_;  // per point
  std::vector<Block> blocks_;                 // by key
  std::vector<std::int32_t> slots_;           // of blocks: open addressing, a power of two

  // The cells of a block whose coordinates in it are low to high, all within 0 to 3.
  static std::uint64_t BitsBetween(const Cell& low, const Cell& high);
  // Of the block at these coordinates, those of its cells over 4; null where no cell is occupied.
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
