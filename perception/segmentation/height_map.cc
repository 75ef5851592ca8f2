#include "perception/segmentation/height_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "perception/cloud/quantile.h"

namespace cwm::perception {
namespace {

constexpr double kNodesPerCell = 4;
// chosen: the density of nodes is estimated on squares of this edge.
constexpr double kDensitySquare_m = 0.02;
// chosen: the finest and the coarsest useful cells.
constexpr double kMinCell_m = 0.004, kMaxCell_m = 0.015;
// chosen: the largest raster, 48 MB.
constexpr double kMaxCells = 4e6;
// chosen: the level of a window is this quantile of the heights of its blocks: things cover less
// than the rest of it.
constexpr double kLevelQuantile = 0.4;
constexpr double kBlock_m = 0.025;
constexpr int kBlockStride = 2;  // of the blocks of a window that are looked at

// The edge of cells with about kNodesPerCell nodes.
double EdgeFor(const std::vector<Vector2>& places) {
  std::map<std::pair<int, int>, double> counts;
  for (const Vector2& p : places) {
    ++counts[{static_cast<int>(std::floor(p.x() / kDensitySquare_m)),
              static_cast<int>(std::floor(p.y() / kDensitySquare_m))}];
  }
  std::vector<double> all;
  for (const auto& [square, count] : counts) all.push_back(count);
  const double per_node_m2 = kDensitySquare_m * kDensitySquare_m / Median(std::move(all));
  return std::clamp(std::sqrt(kNodesPerCell * per_node_m2), kMinCell_m, kMaxCell_m);
}

// Sums over rectangles of cells in constant time.
class RectangleSums {
 public:
  RectangleSums(int width, int height, const std::function<double(std::size_t)>& value)
      : stride_(static_cast<std::size_t>(width) + 1),
        sums_(stride_ * (static_cast<std::size_t>(height) + 1), 0.0) {
    std::size_t cell = 0;
    for (std::size_t v = 1; v <= static_cast<std::size_t>(height); ++v) {
      double row = 0;
      for (std::size_t u = 1; u < stride_; ++u) {
        row += value(cell++);
        sums_[v * stride_ + u] = sums_[(v - 1) * stride_ + u] + row;
      }
    }
  }
  double Of(const CellRange& r) const {
    return At(r.end_u, r.end_v) - At(r.begin_u, r.end_v) - At(r.end_u, r.begin_v) +
           At(r.begin_u, r.begin_v);
  }

 private:
  double At(int u, int v) const {
    return sums_[static_cast<std::size_t>(v) * stride_ + static_cast<std::size_t>(u)];
  }
  std::size_t stride_;
  std::vector<double> sums_;
};

}  // namespace

HeightMap::HeightMap(const SurfaceGraph& graph, const Plane& plane,
                     const std::vector<std::uint32_t>& nodes) {
  const OrientedPoints& points = graph.nodes();
  across_ = BasisFromZ(plane.normal).leftCols<2>();
  std::vector<Vector2> places;
  places.reserve(nodes.size());
  Eigen::AlignedBox2d bounds;
  for (std::uint32_t i : nodes) {
    places.emplace_back(across_.transpose() * points.points[i].cast<double>());
    bounds.extend(places.back());
  }
  corner_m_ = bounds.min();
  edge_m_ = EdgeFor(places);
  edge_m_ = std::max(edge_m_, std::sqrt(bounds.volume() / kMaxCells));
  width_ = static_cast<int>(bounds.sizes().x() / edge_m_) + 1;
  height_ = static_cast<int>(bounds.sizes().y() / edge_m_) + 1;
  cells_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  cell_of_node_.reserve(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const std::uint32_t i = nodes[k];
    const Vector2 at = (places[k] - corner_m_) / edge_m_;
    cell_of_node_.push_back(IndexAt(static_cast<int>(at.x()), static_cast<int>(at.y())));
    Cell& cell = cells_[cell_of_node_.back()];
    const auto weight = static_cast<float>(graph.weight(i));
    const Vector3 ray = points.points[i].cast<double>() - points.viewpoint;
    // The error is along the ray.
    const auto sigma_m =
        static_cast<float>(points.sigma_m[i] * std::abs(plane.normal.dot(ray.normalized())));
    cell.points += weight;
    cell.sum_m += weight * static_cast<float>(plane.Height_m(points.points[i]));
    cell.variance_m2 += weight * sigma_m * sigma_m;
  }
}

std::optional<std::size_t> HeightMap::CellUnder(const Eigen::Vector3f& point) const {
  const Vector2 at = (across_.transpose() * point.cast<double>() - corner_m_) / edge_m_;
  if (at.minCoeff() < 0 || at.x() >= width_ || at.y() >= height_) return std::nullopt;
  return IndexAt(static_cast<int>(at.x()), static_cast<int>(at.y()));
}

int HeightMap::CellsIn(double length_m) const {
  return std::max(1, static_cast<int>(std::lround(length_m / edge_m_)));
}

HeightMap::MeanHeights HeightMap::Smoothed(int reach, double points_per_sample) const {
  const RectangleSums counts(width_, height_, [&](std::size_t i) { return cells_[i].points; });
  const RectangleSums sums(width_, height_, [&](std::size_t i) { return cells_[i].sum_m; });
  const RectangleSums variances(width_, height_,
                                [&](std::size_t i) { return cells_[i].variance_m2; });
  MeanHeights smooth{.height_m = std::vector<float>(cells_.size(), 0.0F),
                     .sigma_m = std::vector<float>(cells_.size(), 0.0F)};
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    if (!cells_[i].has_data()) continue;
    const CellRange around{std::max(0, u(i) - reach), std::min(width_, u(i) + reach + 1),
                           std::max(0, v(i) - reach), std::min(height_, v(i) + reach + 1)};
    const double count = counts.Of(around);
    const double samples = std::max(1.0, count / points_per_sample);
    smooth.height_m[i] = static_cast<float>(sums.Of(around) / count);
    smooth.sigma_m[i] = static_cast<float>(std::sqrt(variances.Of(around) / count / samples));
  }
  return smooth;
}

std::vector<float> HeightMap::Level() const {
  const int block = CellsIn(kBlock_m);
  const int columns = (width_ + block - 1) / block, rows = (height_ + block - 1) / block;
  const auto place = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  };
  std::vector<Cell> blocks(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Cell& sum = blocks[place(u(i) / block, v(i) / block)];
    sum.points += cells_[i].points;
    sum.sum_m += cells_[i].sum_m;
  }
  const int reach = CellsIn(kLevelWindow_m / 2) / block;
  std::vector<float> level(blocks.size(), 0.0F);
  std::vector<float> around;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (!blocks[place(column, row)].has_data()) continue;
      around.clear();
      for (int r = std::max(0, row - reach); r <= std::min(rows - 1, row + reach);
           r += kBlockStride) {
        for (int c = std::max(0, column - reach); c <= std::min(columns - 1, column + reach);
             c += kBlockStride) {
          const Cell& other = blocks[place(c, r)];
          if (other.has_data()) around.push_back(other.height_m());
        }
      }
      level[place(column, row)] =
          around.empty() ? blocks[place(column, row)].height_m() : Quantile(around, kLevelQuantile);
    }
  }
  std::vector<float> of_cell(cells_.size(), 0.0F);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    of_cell[i] = level[place(u(i) / block, v(i) / block)];
  }
  return of_cell;
}

}  // namespace cwm::perception
