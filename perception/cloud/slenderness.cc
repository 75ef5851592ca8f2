#include "perception/cloud/slenderness.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include "perception/cloud/quantile.h"
#include "perception/cloud/seen_width.h"
#include "perception/cloud/tolerances.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {
namespace {

struct Farthest {
  std::size_t cell = 0;
  double away_m = 0;
};

// Dijkstra's shortest paths over touching cells from `start`; marks the cells that they reach.
Farthest FarthestFrom(const VoxelGrid& grid, std::size_t start, std::vector<char>& reached) {
  using Step = std::pair<double, std::size_t>;
  std::vector<double> away_m(grid.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<Step, std::vector<Step>, std::greater<>> steps;
  away_m[start] = 0;
  steps.emplace(0, start);
  Farthest farthest{start, 0};
  while (!steps.empty()) {
    const auto [so_far_m, cell] = steps.top();
    steps.pop();
    if (so_far_m > away_m[cell]) continue;
    farthest = {cell, so_far_m};
    reached[cell] = 1;
    grid.ForEachWithin(1, grid.cell(cell), [&, cell = cell, so_far = so_far_m](std::size_t other) {
      const double to_m = so_far + (grid.Centroid(other) - grid.Centroid(cell)).norm();
      if (to_m < away_m[other]) {
        away_m[other] = to_m;
        steps.emplace(to_m, other);
      }
    });
  }
  return farthest;
}

// The cell farthest from any cell, and the cell farthest from that one, are the ends of the longest
// path, exactly so on a tree. Cells that touch no others hold stray points, so the longest path
// over all components is used.
struct CellPath {
  std::size_t from = 0, to = 0;
  double length_m = 0;
};
CellPath LongestPath(const VoxelGrid& grid) {
  std::vector<char> reached(grid.size(), 0);
  CellPath longest;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (reached[cell]) continue;
    const std::size_t end = FarthestFrom(grid, cell, reached).cell;
    const Farthest other = FarthestFrom(grid, end, reached);
    if (other.away_m >= longest.length_m) longest = {end, other.cell, other.away_m};
  }
  return longest;
}

// The area of the cells that hold points, across the ray to the middle of the cluster. Border cells
// count in proportion to their points.
double SeenArea_m2(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                   double cell_m) {
  Vector3 middle = Vector3::Zero();
  for (const Eigen::Vector3f& p : points) middle += p.cast<double>();
  middle /= static_cast<double>(points.size());
  const Vector3 ray = middle - viewpoint;
  const Matrix3 across = BasisFromZ(ray.norm() > 0 ? Vector3(ray.normalized()) : Vector3::UnitZ());
  std::map<std::pair<long, long>, double> count_of_cell;
  for (const Eigen::Vector3f& p : points) {
    const Vector3 x = across.transpose() * (p.cast<double>() - middle);
    ++count_of_cell[{std::lround(x.x() / cell_m), std::lround(x.y() / cell_m)}];
  }
  std::vector<double> counts;
  for (const auto& [cell, count] : count_of_cell) counts.push_back(count);
  const double full = Quantile(counts, kFullCell);
  double cells = 0;
  for (const auto& [cell, count] : count_of_cell) cells += std::min(1.0, count / full);
  return cells * cell_m * cell_m;
}

}  // namespace

Slenderness MeasureSlenderness(std::span<const Eigen::Vector3f> points, const Vector3& viewpoint,
                               double spacing_m) {
  if (points.empty()) return {};
  const double cell_m = std::max(kThinningSpacing_m, std::sqrt(kMinPointsPerCell) * spacing_m);
  const VoxelGrid grid = VoxelGrid::Build(points, static_cast<float>(cell_m));
  const CellPath way = LongestPath(grid);
  const double length_m = way.length_m + cell_m;
  return {.length_m = length_m,
          .width_m = SeenArea_m2(points, viewpoint, cell_m) / length_m,
          .ends = {grid.Centroid(way.from).cast<double>(), grid.Centroid(way.to).cast<double>()}};
}

}  // namespace cwm::perception
