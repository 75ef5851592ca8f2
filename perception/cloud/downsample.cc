#include "perception/cloud/downsample.h"

namespace cwm::perception {

OrientedPoints Downsample(const OrientedPoints& points, const VoxelGrid& grid, const Work& work) {
  PollEvery poll(work, 1024);  // cells of some 0.1 us
  OrientedPoints cells;
  cells.viewpoint = points.viewpoint;
  for (std::size_t c = 0; c < grid.size(); ++c) {
    poll();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    float sigma = 0, normal_sigma = 0;
    for (std::uint32_t i : grid.PointsOf(c)) {
      normal += points.normals[i];
      sigma += points.sigma_m[i];
      normal_sigma += points.normal_sigma_rad[i];
    }
    const float n = static_cast<float>(grid.PointsOf(c).size());
    const bool cancelled = normal.norm() < 0.1f * n;
    cells.points.push_back(grid.Centroid(c));
    cells.normals.push_back(cancelled ? Eigen::Vector3f::Zero().eval()
                                      : normal.normalized().eval());
    cells.sigma_m.push_back(sigma / n);
    cells.normal_sigma_rad.push_back(normal_sigma / n);
    cells.cloud_index.push_back(points.cloud_index[grid.PointsOf(c)[0]]);
  }
  return cells;
}

}  // namespace cwm::perception
