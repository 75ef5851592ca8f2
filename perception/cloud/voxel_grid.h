// One fixed spatial decomposition of a cloud (paper, section IV): cells on sorted Morton keys with
// the sums of their points, which serve downsampling, centroids, covariances and neighbour lookup.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
// points within a cell keep their order.
class VoxelGrid {
 public:
  using Cell = Eigen::Vector3i;
  static constexpr std::int32_t kNone = -1;

  // All points must be finite. The edge is doubled until the extent fits 2^21 cells per axis (4 mm
  // cells: 8 km). Linear time in the points, however many share one place.
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

  // f(index) for the occupied ones of the 27 cells around these coordinates, the middle one among
  // them, in the order of z, then y, then x. Ends early, and is true, once f returns true.
  template <class F>
  bool AnyNeighbour(const Cell& cell, F&& f) const;

  // Index of the occupied cell at these coordinates, or kNone.
  std::int32_t Find(const Cell& cell) const;

 private:
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  float edge_m_ = 1;
  std::vector<Cell> cells_;
  std::vector<Moments> moments_;
  std::vector<std::uint32_t> first_;          // per cell and one more: where its points begin
  std::vector<std::uint32_t> order_;          // points sorted by cell
  std::vector<std::uint32_t> cell_of_point_;  // per point
  std::vector<std::int32_t> slots_;           // open addressing, a power of two

  // The steps of building, in their order.
  void FindCells(std::span<const Eigen::Vector3f> points, const Work& work);
  void SortCells(const Work& work);
  void SortPoints(const Work& work);
  std::uint32_t FindOrAdd(const Cell& cell);
  std::size_t Slot(const Cell& cell) const;
  void IndexCells();
};

template <class F>
bool VoxelGrid::AnyNeighbour(const Cell& cell, F&& f) const {
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const std::int32_t other = Find(cell + Cell(x, y, z));
        if (other != kNone && f(static_cast<std::size_t>(other))) return true;
      }
    }
  }
  return false;
}

}  // namespace cwm::perception
