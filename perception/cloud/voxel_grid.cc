#include "perception/cloud/voxel_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "perception/cloud/morton.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/split_mix.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// derived: the number of cells that keys distinguish; one at either end is left for rounding.
constexpr float kCellsPerAxis = static_cast<float>((1 << kMortonBitsPerAxis) - 2);

std::uint64_t KeyOf(const VoxelGrid::Cell& cell) {
  return MortonKey(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                   static_cast<std::uint32_t>(cell.z()));
}

// True if a key can represent the coordinates: they are not negative and not too large.
bool HasKey(const VoxelGrid::Cell& cell) {
  const auto all = static_cast<std::uint32_t>(cell.x() | cell.y() | cell.z());
  return all >> kMortonBitsPerAxis == 0;
}

// [axis][low][high]: the bits of the cells of a block whose coordinate on that axis is from low to
// high.
using AxisRanges = std::array<std::array<std::array<std::uint64_t, 4>, 4>, 3>;

constexpr AxisRanges MakeAxisRanges() {
  AxisRanges ranges{};
  for (unsigned bit = 0; bit < VoxelGrid::kCellsOfBlock; ++bit) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      const unsigned at = (bit >> axis & 1) | (bit >> (axis + 3) & 1) << 1;
      for (unsigned low = 0; low <= at; ++low) {
        for (unsigned high = at; high < 4; ++high) {
          ranges[axis][low][high] |= std::uint64_t{1} << bit;
        }
      }
    }
  }
  return ranges;
}

constexpr AxisRanges kAxisRanges = MakeAxisRanges();

struct KeyedBlock {
  std::uint64_t key;
  std::uint32_t block;
};

// Stable radix sort by key, one byte per pass, with only as many passes as the largest key needs.
void SortByKey(std::vector<KeyedBlock>& items, const Work& work) {
  using Digit = std::uint8_t;
  constexpr std::size_t kLastDigit = std::numeric_limits<Digit>::max();
  std::uint64_t all = 0;
  for (const KeyedBlock& item : items) all |= item.key;
  std::vector<KeyedBlock> other(items.size());
  for (int shift = 0; shift < 64 && all >> shift; shift += std::numeric_limits<Digit>::digits) {
    work.Poll();
    const auto digit = [&](const KeyedBlock& item) -> std::size_t {
      return static_cast<Digit>(item.key >> shift);
    };
    std::array<std::size_t, kLastDigit + 2> start{};
    for (const KeyedBlock& item : items) ++start[digit(item) + 1];
    for (std::size_t d = 0; d <= kLastDigit; ++d) start[d + 1] += start[d];
    for (const KeyedBlock& item : items) other[start[digit(item)]++] = item;
    items.swap(other);
  }
}

}  // namespace

void Moments::Add(const Moments& other, const Eigen::Vector3f& o) {
  const Eigen::Vector3f& s = other.sum;
  const float n = static_cast<float>(other.count);
  products[0] += other.products[0] + 2 * o.x() * s.x() + n * o.x() * o.x();
  products[1] += other.products[1] + o.x() * s.y() + o.y() * s.x() + n * o.x() * o.y();
  products[2] += other.products[2] + o.x() * s.z() + o.z() * s.x() + n * o.x() * o.z();
  products[3] += other.products[3] + 2 * o.y() * s.y() + n * o.y() * o.y();
  products[4] += other.products[4] + o.y() * s.z() + o.z() * s.y() + n * o.y() * o.z();
  products[5] += other.products[5] + 2 * o.z() * s.z() + n * o.z() * o.z();
  sum += s + n * o;
  count += other.count;
}

Eigen::Matrix3f Moments::Covariance() const {
  const float n = static_cast<float>(count);
  const Eigen::Vector3f m = sum / n;
  Eigen::Matrix3f c;
  c << products[0], products[1], products[2], products[1], products[3], products[4], products[2],
      products[4], products[5];
  return c / n - m * m.transpose();
}

VoxelGrid VoxelGrid::Build(std::span<const Eigen::Vector3f> points, float edge_m,
                           const Work& work) {
  VoxelGrid grid = BuildCells(points, edge_m, work);
  grid.AccumulateMoments(points, work);
  return grid;
}

VoxelGrid VoxelGrid::BuildCells(std::span<const Eigen::Vector3f> points, float edge_m,
                                const Work& work) {
  VoxelGrid grid;
  if (points.empty()) return grid;
  if (points.size() > kMaxPoints) throw std::length_error("a voxel grid holds at most 2^26 points");
  Eigen::Vector3f low = points[0], high = points[0];
  for (const Eigen::Vector3f& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  grid.edge_m_ = edge_m;
  while ((high - low).maxCoeff() / grid.edge_m_ > kCellsPerAxis) grid.edge_m_ *= 2;
  grid.origin_ = low;
  grid.FindCells(points, work);
  grid.SortBlocks(work);
  grid.SortPoints(work);
  return grid;
}

// Until the blocks are sorted, a point's cell is stored as its block and its bit.
void VoxelGrid::FindCells(std::span<const Eigen::Vector3f> points, const Work& work) {
  const float per_edge = 1 / edge_m_;
  cell_of_point_.resize(points.size());
  IndexBlocks();
  PollEvery poll(work, ItemsPerChunk(50ns));
  std::uint64_t latest = ~std::uint64_t{0};  // successive points are mostly in one block
  std::uint32_t index = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    poll();
    // Never negative, so truncation is the floor.
    const Cell cell = ((points[i] - origin_) * per_edge).cast<int>();
    const std::uint64_t key = KeyOf(cell);
    if (key >> kBitsOfBlock != latest) {
      latest = key >> kBitsOfBlock;
      index = FindOrAddBlock(latest);
    }
    const auto bit = static_cast<std::uint32_t>(key & (kCellsOfBlock - 1));
    blocks_[index].occupied |= std::uint64_t{1} << bit;
    cell_of_point_[i] = index << kBitsOfBlock | bit;
  }
}

std::uint32_t VoxelGrid::FindOrAddBlock(std::uint64_t key) {
  std::size_t slot = Slot(key);
  for (; slots_[slot] != kNoIndex; slot = (slot + 1) & (slots_.size() - 1)) {
    const auto found = static_cast<std::uint32_t>(slots_[slot]);
    if (blocks_[found].key == key) return found;
  }
  slots_[slot] = static_cast<std::int32_t>(blocks_.size());
  blocks_.push_back({.key = key});
  if (2 * blocks_.size() > slots_.size()) IndexBlocks();
  return static_cast<std::uint32_t>(blocks_.size() - 1);
}

void VoxelGrid::SortBlocks(const Work& work) {
  std::vector<KeyedBlock> sorted;
  sorted.reserve(blocks_.size());
  for (std::uint32_t b = 0; b < blocks_.size(); ++b) sorted.push_back({blocks_[b].key, b});
  SortByKey(sorted, work);
  std::vector<Block> blocks;
  blocks.reserve(blocks_.size());
  std::vector<std::uint32_t> place(blocks_.size());
  std::uint32_t cells = 0;
  for (const KeyedBlock& item : sorted) {
    place[item.block] = static_cast<std::uint32_t>(blocks.size());
    Block& block = blocks.emplace_back(blocks_[item.block]);
    block.first = cells;
    cells += static_cast<std::uint32_t>(std::popcount(block.occupied));
  }
  blocks_ = std::move(blocks);
  IndexBlocks();
  ListCells(cells);
  PollEvery poll(work, ItemsPerChunk(50ns));
  for (std::uint32_t& cell : cell_of_point_) {
    poll();
    const Block& block = blocks_[place[cell >> kBitsOfBlock]];
    cell = static_cast<std::uint32_t>(block.IndexOf(cell & (kCellsOfBlock - 1)));
  }
}

void VoxelGrid::ListCells(std::size_t count) {
  cells_.reserve(count);
  for (const Block& block : blocks_) {
    for (std::uint64_t left = block.occupied; left != 0; left &= left - 1) {
      const std::uint64_t key =
          block.key << kBitsOfBlock | static_cast<std::uint64_t>(std::countr_zero(left));
      cells_.push_back({static_cast<int>(GatherBits(key)), static_cast<int>(GatherBits(key >> 1)),
                        static_cast<int>(GatherBits(key >> 2))});
    }
  }
}

void VoxelGrid::SortPoints(const Work& work) {
  PollEvery poll(work, ItemsPerChunk(50ns));
  first_.assign(cells_.size() + 1, 0);
  for (std::uint32_t cell : cell_of_point_) {
    poll();
    ++first_[cell + 1];
  }
  for (std::size_t c = 0; c < cells_.size(); ++c) first_[c + 1] += first_[c];
  std::vector<std::uint32_t> next = first_;
  order_.resize(cell_of_point_.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) {
    poll();
    order_[next[cell_of_point_[i]]++] = i;
  }
}

std::vector<std::uint32_t> VoxelGrid::Renumber() {
  std::vector<std::uint32_t> before(order_.size());
  before.swap(order_);
  std::iota(order_.begin(), order_.end(), 0U);
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    std::fill(cell_of_point_.begin() + first_[c], cell_of_point_.begin() + first_[c + 1], c);
  }
  return before;
}

void VoxelGrid::AccumulateMoments(std::span<const Eigen::Vector3f> points, const Work& work) {
  moments_.resize(cells_.size());
  // About ten points per cell.
  ParallelFor(cells_.size(), ItemsPerChunk(800ns), work, [&](std::size_t begin, std::size_t end) {
    PollEvery poll(work, ItemsPerChunk(50ns));
    for (std::size_t c = begin; c < end; ++c) {
      const Eigen::Vector3f center = Center(c);
      Moments sums;
      for (std::uint32_t i : PointsOf(c)) {
        poll();  // millions of points may share one place
        sums.Add(points[i] - center);
      }
      moments_[c] = sums;
    }
  });
}

Eigen::Vector3f VoxelGrid::Center(std::size_t i) const {
  return origin_ + edge_m_ * (cells_[i].cast<float>() + Eigen::Vector3f::Constant(0.5f));
}

std::span<const std::uint32_t> VoxelGrid::PointsOf(std::size_t i) const {
  return {order_.data() + first_[i], order_.data() + first_[i + 1]};
}

std::uint64_t VoxelGrid::BitsBetween(const Cell& low, const Cell& high) {
  std::uint64_t bits = ~std::uint64_t{0};
  for (int axis = 0; axis < 3; ++axis) {
    const auto from = static_cast<std::size_t>(low[axis]),
               to = static_cast<std::size_t>(high[axis]);
    bits &= kAxisRanges[static_cast<std::size_t>(axis)][from][to];
  }
  return bits;
}

std::size_t VoxelGrid::Slot(std::uint64_t key) const {
  return (key * kGoldenGamma >> 32) & (slots_.size() - 1);  // Fibonacci hashing
}

void VoxelGrid::IndexBlocks() {
  slots_.assign(std::bit_ceil(4 * std::max<std::size_t>(1, blocks_.size())), kNoIndex);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    std::size_t slot = Slot(blocks_[i].key);
    while (slots_[slot] != kNoIndex) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<std::int32_t>(i);
  }
}

const VoxelGrid::Block* VoxelGrid::FindBlock(const Cell& block) const {
  if (slots_.empty() || !HasKey(block)) return nullptr;
  const std::uint64_t key = KeyOf(block);
  for (std::size_t slot = Slot(key);; slot = (slot + 1) & (slots_.size() - 1)) {
    if (slots_[slot] == kNoIndex) return nullptr;
    const Block& found = blocks_[static_cast<std::size_t>(slots_[slot])];
    if (found.key == key) return &found;
  }
}

std::int32_t VoxelGrid::Find(const Cell& cell) const {
  if (!HasKey(cell)) return kNoIndex;
  const Block* block = FindBlock(cell.unaryExpr([](int c) { return c >> kBlockShift; }));
  const auto bit = static_cast<int>(KeyOf(cell) & (kCellsOfBlock - 1));
  if (!block || (block->occupied >> bit & 1) == 0) return kNoIndex;
  return static_cast<std::int32_t>(block->IndexOf(bit));
}

}  // namespace cwm::perception
