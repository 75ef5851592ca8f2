#include "perception/cloud/voxel_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "perception/cloud/morton.h"
#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

constexpr int kPointsPerPiece = 8192;        // of less than 0.1 us each
constexpr std::size_t kCellsPerPiece = 512;  // some ten points each
constexpr float kCellsPerAxis = static_cast<float>((1 << kMortonBitsPerAxis) - 2);

std::uint64_t KeyOf(const VoxelGrid::Cell& cell) {
  return MortonKey(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                   static_cast<std::uint32_t>(cell.z()));
}

struct KeyedCell {
  std::uint64_t key;
  std::uint32_t cell;
};

// Stable radix sort by key, 11 bits a pass, only as many passes as the largest key needs.
void SortByKey(std::vector<KeyedCell>& items, const Work& work) {
  constexpr int kDigitBits = 11;
  constexpr std::size_t kDigits = 1 << kDigitBits;
  std::uint64_t all = 0;
  for (const KeyedCell& item : items) all |= item.key;
  std::vector<KeyedCell> other(items.size());
  for (int shift = 0; shift < 64 && all >> shift; shift += kDigitBits) {
    work.Poll();
    std::array<std::size_t, kDigits + 1> start{};
    for (const KeyedCell& item : items) ++start[(item.key >> shift & (kDigits - 1)) + 1];
    for (std::size_t d = 0; d < kDigits; ++d) start[d + 1] += start[d];
    for (const KeyedCell& item : items) other[start[item.key >> shift & (kDigits - 1)]++] = item;
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
  grid.SumUp(points, work);
  return grid;
}

VoxelGrid VoxelGrid::BuildCells(std::span<const Eigen::Vector3f> points, float edge_m,
                                const Work& work) {
  VoxelGrid grid;
  if (points.empty()) return grid;
  Eigen::Vector3f low = points[0], high = points[0];
  for (const Eigen::Vector3f& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  grid.edge_m_ = edge_m;
  while ((high - low).maxCoeff() / grid.edge_m_ > kCellsPerAxis) grid.edge_m_ *= 2;
  grid.origin_ = low;
  grid.FindCells(points, work);
  grid.SortCells(work);
  grid.SortPoints(work);
  return grid;
}

void VoxelGrid::FindCells(std::span<const Eigen::Vector3f> points, const Work& work) {
  const float per_edge = 1 / edge_m_;
  cell_of_point_.resize(points.size());
  IndexCells();
  PollEvery poll(work, kPointsPerPiece);
  Cell latest = Cell::Constant(kNone);  // points that follow each other are mostly in one cell
  std::uint32_t index = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    poll();
    // Never negative: truncated is the floor.
    const Cell cell = ((points[i] - origin_) * per_edge).cast<int>();
    if (cell != latest) {
      index = FindOrAdd(cell);
      latest = cell;
    }
    cell_of_point_[i] = index;
  }
}

std::uint32_t VoxelGrid::FindOrAdd(const Cell& cell) {
  std::size_t slot = Slot(cell);
  for (; slots_[slot] != kNone; slot = (slot + 1) & (slots_.size() - 1)) {
    const auto found = static_cast<std::uint32_t>(slots_[slot]);
    if (cells_[found] == cell) return found;
  }
  slots_[slot] = static_cast<std::int32_t>(cells_.size());
  cells_.push_back(cell);
  if (2 * cells_.size() > slots_.size()) IndexCells();
  return static_cast<std::uint32_t>(cells_.size() - 1);
}

void VoxelGrid::SortCells(const Work& work) {
  std::vector<KeyedCell> sorted;
  sorted.reserve(cells_.size());
  for (std::uint32_t c = 0; c < cells_.size(); ++c) sorted.push_back({KeyOf(cells_[c]), c});
  SortByKey(sorted, work);
  std::vector<Cell> cells;
  cells.reserve(cells_.size());
  std::vector<std::uint32_t> place(cells_.size());
  for (const KeyedCell& item : sorted) {
    place[item.cell] = static_cast<std::uint32_t>(cells.size());
    cells.push_back(cells_[item.cell]);
  }
  cells_ = std::move(cells);
  IndexCells();
  PollEvery poll(work, kPointsPerPiece);
  for (std::uint32_t& cell : cell_of_point_) {
    poll();
    cell = place[cell];
  }
}

void VoxelGrid::SortPoints(const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
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

void VoxelGrid::SumUp(std::span<const Eigen::Vector3f> points, const Work& work) {
  moments_.resize(cells_.size());
  ParallelFor(cells_.size(), kCellsPerPiece, work, [&](std::size_t begin, std::size_t end) {
    PollEvery poll(work, kPointsPerPiece);
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

std::size_t VoxelGrid::Slot(const Cell& cell) const {
  // Fibonacci hashing of a mix of the coordinates.
  std::uint64_t h = static_cast<std::uint32_t>(cell.x());
  h = h * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(cell.y());
  h = h * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(cell.z());
  h *= 0x9e3779b97f4a7c15ULL;
  return (h >> 32) & (slots_.size() - 1);
}

void VoxelGrid::IndexCells() {
  slots_.assign(std::bit_ceil(4 * std::max<std::size_t>(1, cells_.size())), kNone);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    std::size_t slot = Slot(cells_[i]);
    while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = static_cast<std::int32_t>(i);
  }
}

std::int32_t VoxelGrid::Find(const Cell& cell) const {
  if (slots_.empty()) return kNone;
  for (std::size_t slot = Slot(cell);; slot = (slot + 1) & (slots_.size() - 1)) {
    const std::int32_t found = slots_[slot];
    if (found == kNone || cells_[static_cast<std::size_t>(found)] == cell) return found;
  }
}

}  // namespace cwm::perception
