#include "perception/search/connectivity.h"

#include <algorithm>

#include "perception/cloud/quantile.h"

namespace cwm::perception {
namespace {

// Inliers of one surface connect across the distance gate. Surfaces are uneven by part of a cell,
// even if all points are in one place.
double CellEdge_m(const ModelPoints& points) {
  return std::max({kSpacingsPerCell * points.spacing_m,
                   kDistanceGate_sigma * Median(points.sigma_m), double{kUnevenness_m}});
}

std::vector<Eigen::Vector3f> AsFloat(const std::vector<Vector3>& points) {
  std::vector<Eigen::Vector3f> out;
  out.reserve(points.size());
  for (const Vector3& p : points) out.push_back(p.cast<float>());
  return out;
}

}  // namespace

Connectivity::Connectivity(const ModelPoints& points)
    : Connectivity(AsFloat(points.p), static_cast<float>(CellEdge_m(points))) {}

Connectivity::Connectivity(std::span<const Eigen::Vector3f> points, float edge_m)
    : grid_(VoxelGrid::Build(points, edge_m)) {
  LinkCells();
}

void Connectivity::LinkCells() {
  first_.assign(1, 0);
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    grid_.ForEachWithin(1, grid_.cell(i), [&](std::size_t other) {
      if (other != i) neighbours_.push_back(static_cast<std::uint32_t>(other));
    });
    first_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
  }
}

std::vector<std::vector<std::uint32_t>> Connectivity::Components(
    std::span<const std::uint32_t> listed) const {
  enum : std::uint32_t { kEmpty, kUnvisited, kFirstLabel };
  std::vector<std::uint32_t> component_of(grid_.size(), kEmpty);
  for (std::uint32_t i : listed) component_of[grid_.CellOfPoint(i)] = kUnvisited;
  std::vector<std::vector<std::uint32_t>> components;
  std::vector<std::uint32_t> stack;
  for (std::uint32_t i : listed) {
    const std::uint32_t seed = grid_.CellOfPoint(i);
    if (component_of[seed] == kUnvisited) {
      const auto label = static_cast<std::uint32_t>(components.size()) + kFirstLabel;
      components.emplace_back();
      component_of[seed] = label;
      stack.push_back(seed);
      while (!stack.empty()) {
        const std::uint32_t cell = stack.back();
        stack.pop_back();
        for (std::uint32_t k = first_[cell]; k < first_[cell + 1]; ++k) {
          if (component_of[neighbours_[k]] != kUnvisited) continue;
          component_of[neighbours_[k]] = label;
          stack.push_back(neighbours_[k]);
        }
      }
    }
    components[component_of[seed] - kFirstLabel].push_back(i);
  }
  std::stable_sort(components.begin(), components.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return components;
}

std::vector<std::uint32_t> Connectivity::LargestComponent(
    std::span<const std::uint32_t> listed) const {
  std::vector<std::vector<std::uint32_t>> components = Components(listed);
  return components.empty() ? std::vector<std::uint32_t>() : std::move(components.front());
}

std::vector<std::uint32_t> Connectivity::Beside(std::span<const std::uint32_t> listed) const {
  std::vector<char> marked(grid_.size(), 0);
  for (std::uint32_t i : listed) {
    const std::uint32_t cell = grid_.CellOfPoint(i);
    marked[cell] = 1;
    for (std::uint32_t k = first_[cell]; k < first_[cell + 1]; ++k) marked[neighbours_[k]] = 1;
  }
  std::vector<std::uint32_t> beside;
  for (std::size_t cell = 0; cell < grid_.size(); ++cell) {
    if (!marked[cell]) continue;
    const std::span<const std::uint32_t> members = grid_.PointsOf(cell);
    beside.insert(beside.end(), members.begin(), members.end());
  }
  std::sort(beside.begin(), beside.end());
  return beside;
}

}  // namespace cwm::perception
