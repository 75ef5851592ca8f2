#include "perception/cloud/voxel_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "perception/cloud/morton.h"
#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

constexpr int kPointsPerPiece = 8192;  // of less than 0.1 us each
constexpr int kRunsPerPiece = 4096;
constexpr std::size_t kCellsPerPiece = 512;  // some ten points each
constexpr float kCellsPerAxis = static_cast<float>((1 << kMortonBitsPerAxis) - 2);

std::uint64_t KeyOf(const VoxelGrid::Cell& cell) {
  return MortonKey(static_cast<std::uint32_t>(cell.x()), static_cast<std::uint32_t>(cell.y()),
                   static_cast<std::uint32_t>(cell.z()));
}

// Points that follow each other in the cloud and lie in one cell: in an image, some ten.
struct Run {
  std::uint64_t key;
  std::uint32_t begin, end;  // points
};

template <class CellOf>
std::vector<Run> RunsOf(std::size_t points, const CellOf& cell_of, const Work& work) {
  std::vector<Run> runs;
  PollEvery poll(work, kPointsPerPiece);
  VoxelGrid::Cell latest = VoxelGrid::Cell::Constant(VoxelGrid::kNone);
  for (std::uint32_t i = 0; i < points; ++i) {
    poll();
    const VoxelGrid::Cell cell = cell_of(i);
    if (cell == latest) {
      runs.back().end = i + 1;
    } else {
      runs.push_back({KeyOf(cell), i, i + 1});
      latest = cell;
    }
  }
  return runs;
}

// Stable radix sort by key, 11 bits a pass, only as many passes as the largest key needs.
void SortByKey(std::vector<Run>& items, const Work& work) {
  constexpr int kDigitBits = 11;
  constexpr std::size_t kDigits = 1 << kDigitBits;
  std::uint64_t all = 0;
  for (const Run& item : items) all |= item.key;
  std::vector<Run> other(items.size());
  for (int shift = 0; shift < 64 && all >> shift; shift += kDigitBits) {
    work.Poll();
    std::array<std::size_t, kDigits + 1> start{};
    for (const Run& item : items) ++start[(item.key >> shift & (kDigits - 1)) + 1];
    for (std::size_t d = 0; d < kDigits; ++d) start[d + 1] += start[d];
    for (const Run& item : items) other[start[item.key >> shift & (kDigits - 1)]++] = item;
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
  const float per_edge = 1 / grid.edge_m_;
  const auto cell_of = [points, low, per_edge](std::size_t i) -> Cell {
    return ((points[i] - low) * per_edge).cast<int>();  // never negative: truncated is the floor
  };
  std::vector<Run> runs = RunsOf(points.size(), cell_of, work);
  SortByKey(runs, work);
  grid.order_.resize(points.size());
  grid.cell_of_point_.resize(points.size());
  PollEvery poll(work, kRunsPerPiece);
  std::uint32_t placed = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    poll();
    if (r == 0 || runs[r].key != runs[r - 1].key) {
      grid.first_.push_back(placed);
      grid.cells_.push_back(cell_of(runs[r].begin));
    }
    const auto cell = static_cast<std::uint32_t>(grid.cells_.size() - 1);
    for (std::uint32_t i = runs[r].begin; i < runs[r].end; ++i) {
      grid.order_[placed++] = i;
      grid.cell_of_point_[i] = cell;
    }
  }
  grid.first_.push_back(placed);
  grid.SumUp(points, work);
  grid.IndexCells();
  return grid;
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
  slots_.assign(std::bit_ceil(2 * cells_.size()), kNone);
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
