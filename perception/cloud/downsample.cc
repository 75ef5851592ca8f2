#include "perception/cloud/downsample.h"

#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

void SetCell(const OrientedPoints& points, const VoxelGrid& grid, std::size_t c, PollEvery& poll,
             OrientedPoints& cells) {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float sigma = 0, normal_sigma = 0;
  for (std::uint32_t i : grid.PointsOf(c)) {
    poll();
    normal += points.normals[i];
    sigma += points.sigma_m[i];
    normal_sigma += points.normal_sigma_rad[i];
  }
  const float n = static_cast<float>(grid.PointsOf(c).size());
  const bool cancelled = normal.norm() < 0.1f * n;
  cells.points[c] = grid.Centroid(c);
  if (!cancelled) cells.normals[c] = normal.normalized();
  cells.sigma_m[c] = sigma / n;
  cells.normal_sigma_rad[c] = normal_sigma / n;
  cells.cloud_index[c] = points.cloud_index[grid.PointsOf(c)[0]];
}

}  // namespace

OrientedPoints Downsample(const OrientedPoints& points, const VoxelGrid& grid, const Work& work) {
  OrientedPoints cells;
  cells.viewpoint = points.viewpoint;
  cells.spread = points.spread;
  cells.points_per_sample = points.points_per_sample;
  cells.warp_m = points.warp_m;
  cells.points.resize(grid.size());
  cells.normals.assign(grid.size(), Eigen::Vector3f::Zero());
  cells.sigma_m.resize(grid.size());
  cells.normal_sigma_rad.resize(grid.size());
  cells.cloud_index.resize(grid.size());
  ParallelFor(grid.size(), ItemsPerChunk(500ns), work, [&](std::size_t begin, std::size_t end) {
    PollEvery poll(work, ItemsPerChunk(6ns));  // millions of points may share one cell
    for (std::size_t c = begin; c < end; ++c) SetCell(points, grid, c, poll, cells);
  });
  return cells;
}

}  // namespace cwm::perception
