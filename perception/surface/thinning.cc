#include "perception/surface/thinning.h"

namespace cwm::perception {
namespace {

constexpr std::int32_t kOpen = -1;

// The vertex of a neighbouring cell that lies too close to `p`, or kOpen.
std::int32_t CloseVertex(const ThinnedPoints& thinned, std::size_t cell, const Eigen::Vector3f& p) {
  const VoxelGrid& grid = thinned.grid;
  const float closest_m = kClosestVertices * grid.edge_m();
  std::int32_t close = kOpen;
  grid.AnyWithin(1, grid.cell(cell), [&](std::size_t other) {
    const std::int32_t vertex = thinned.vertex_of_cell[other];
    if (vertex == kOpen || (thinned.vertices[vertex] - p).norm() >= closest_m) return false;
    close = vertex;
    return true;
  });
  return close;
}

}  // namespace

ThinnedPoints Thin(std::span<const Eigen::Vector3f> points, float spacing_m, const Work& work) {
  PollEvery poll(work, 256);  // cells of some microseconds
  ThinnedPoints thinned{
      .grid = VoxelGrid::Build(points, spacing_m, work), .vertices = {}, .vertex_of_cell = {}};
  thinned.vertex_of_cell.assign(thinned.grid.size(), kOpen);
  for (std::size_t i = 0; i < thinned.grid.size(); ++i) {
    poll();
    const Eigen::Vector3f centroid = thinned.grid.Centroid(i);
    std::int32_t vertex = CloseVertex(thinned, i, centroid);
    if (vertex == kOpen) {
      vertex = static_cast<std::int32_t>(thinned.vertices.size());
      thinned.vertices.push_back(centroid);
    }
    thinned.vertex_of_cell[i] = vertex;
  }
  return thinned;
}

}  // namespace cwm::perception
