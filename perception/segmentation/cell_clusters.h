// Cells of a coarse cloud that hang together.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {

// A coarse cloud, or one whose cells' normals are turned.
struct CellView {
  const VoxelGrid& grid;
  const OrientedPoints& cells;
};

// Connected sets of eligible cells; `joined(a, b)` decides for neighbours. Largest first, each
// ascending.
template <class Eligible, class Joined>
std::vector<std::vector<std::uint32_t>> ClusterCells(const CellView& coarse, Eligible&& eligible,
                                                     Joined&& joined) {
  std::vector<char> visited(coarse.cells.size(), 0);
  std::vector<std::vector<std::uint32_t>> clusters;
  for (std::uint32_t start = 0; start < coarse.cells.size(); ++start) {
    if (visited[start] || !eligible(start)) continue;
    std::vector<std::uint32_t> members{start};
    visited[start] = 1;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const std::uint32_t member = members[k];
      coarse.grid.ForEachWithin(1, coarse.grid.cell(member), [&](std::size_t found) {
        const auto other = static_cast<std::uint32_t>(found);
        if (visited[other] || !eligible(other) || !joined(member, other)) return;
        visited[other] = 1;
        members.push_back(other);
      });
    }
    std::sort(members.begin(), members.end());
    clusters.push_back(std::move(members));
  }
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return clusters;
}

}  // namespace cwm::perception
