// Connected clusters of the cells of a coarse cloud.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "perception/cloud/oriented_points.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {

// A coarse cloud, or a copy of its cells with flipped normals.
struct CellView {
  const VoxelGrid& grid;
  const OrientedPoints& cells;
};

// Returns the connected sets of eligible cells, largest first, the cells of each in ascending
// order. `joined(a, b)` decides whether two neighbouring cells belong to one set.
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
