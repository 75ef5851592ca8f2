#include "perception/surface/thinning.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// The vertex of a neighbouring cell that is too close to `p`, or kNoIndex.
std::int32_t CloseVertex(const ThinnedPoints& thinned, std::size_t cell, const Eigen::Vector3f& p) {
  const VoxelGrid& grid = thinned.grid;
  const float closest_m = kMinVertexGap * grid.edge_m();
  std::int32_t close = kNoIndex;
  grid.AnyWithin(1, grid.cell(cell), [&](std::size_t other) {
    const std::int32_t vertex = thinned.vertex_of_cell[other];
    if (vertex == kNoIndex || (thinned.vertices[vertex] - p).norm() >= closest_m) return false;
    close = vertex;
    return true;
  });
  return close;
}

}  // namespace

ThinnedPoints Thin(std::span<const Eigen::Vector3f> points, float spacing_m, const Work& work) {
  PollEvery poll(work, ItemsPerChunk(2us));
  ThinnedPoints thinned{
      .grid = VoxelGrid::Build(points, spacing_m, work), .vertices = {}, .vertex_of_cell = {}};
  thinned.vertex_of_cell.assign(thinned.grid.size(), kNoIndex);
  for (std::size_t i = 0; i < thinned.grid.size(); ++i) {
    poll();
    const Eigen::Vector3f centroid = thinned.grid.Centroid(i);
    std::int32_t vertex = CloseVertex(thinned, i, centroid);
    if (vertex == kNoIndex) {
      vertex = static_cast<std::int32_t>(thinned.vertices.size());
      thinned.vertices.push_back(centroid);
    }
    thinned.vertex_of_cell[i] = vertex;
  }
  return thinned;
}

}  // namespace cwm::perception
