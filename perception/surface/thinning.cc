#include "perception/surface/thinning.h"

namespace cwm::perception {
namespace {

constexpr std::int32_t kOpen = -1;

// The vertex of a neighbouring cell that lies too close to `p`, or kOpen.
std::int32_t CloseVertex(const ThinnedPoints& thinned, std::size_t cell, const Eigen::Vector3f& p) {
  const VoxelGrid& grid = thinned.grid;
  const float closest_m = kClosestVertices * grid.edge_m();
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const std::int32_t other = grid.Find(grid.cell(cell) + VoxelGrid::Cell(x, y, z));
        if (other == VoxelGrid::kNone) continue;
        const std::int32_t vertex = thinned.vertex_of_cell[other];
        if (vertex == kOpen) continue;
        if ((thinned.vertices[vertex] - p).norm() < closest_m) return vertex;
      }
    }
  }
  return kOpen;
}

}  // namespace

ThinnedPoints Thin(std::span<const Eigen::Vector3f> points, float spacing_m) {
  ThinnedPoints thinned{
      .grid = VoxelGrid::Build(points, spacing_m), .vertices = {}, .vertex_of_cell = {}};
  thinned.vertex_of_cell.assign(thinned.grid.size(), kOpen);
  for (std::size_t i = 0; i < thinned.grid.size(); ++i) {
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
