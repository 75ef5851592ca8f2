#include "perception/segmentation/surface_graph.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "perception/cloud/normals.h"
#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

std::vector<float> Ranges(const OrientedPoints& nodes, const Work& work) {
  std::vector<float> range_m(nodes.size());
  const Eigen::Vector3f viewpoint = nodes.viewpoint.cast<float>();
  ParallelFor(nodes.size(), ItemsPerChunk(5ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) range_m[i] = (nodes.points[i] - viewpoint).norm();
  });
  return range_m;
}

float Squared(float x) { return x * x; }

}  // namespace

SurfaceGraph SurfaceGraph::OfImage(const MeasuredPoints& measured, const Work& work) {
  SurfaceGraph graph;
  graph.measured_ = &measured;
  graph.nodes_ = &measured.oriented;
  graph.range_m_ = Ranges(measured.oriented, work);
  graph.planes_ = std::make_shared<SurfacePlanes>(PlanesOfSurface(measured, graph.range_m_, work));
  graph.LinkPixels(work);
  return graph;
}

SurfaceGraph SurfaceGraph::OfGrid(const OrientedPoints& nodes, const VoxelGrid& grid,
                                  const Work& work) {
  SurfaceGraph graph;
  graph.grid_ = &grid;
  graph.nodes_ = &nodes;
  graph.range_m_ = Ranges(*graph.nodes_, work);
  graph.LinkCells(work);
  return graph;
}

std::int32_t SurfaceGraph::AtPixel(int row, int column) const {
  if (row < 0 || column < 0 || row >= measured_->height || column >= measured_->width) {
    return kNoIndex;
  }
  return measured_
      ->image[static_cast<std::size_t>(row) * static_cast<std::size_t>(measured_->width) +
              static_cast<std::size_t>(column)];
}

double SurfaceGraph::area_m2(std::size_t node) const {
  if (grid_) return double{grid_->edge_m()} * grid_->edge_m();
  // A pixel's cone widens with the range and is cut at the angle of incidence, at most 80 degrees.
  const Eigen::Vector3f ray = nodes_->points[node] - nodes_->viewpoint.cast<float>();
  const double side = double{range_m_[node]} * measured_->pixel_angle_rad;
  const double cosine = std::abs(nodes_->normals[node].dot(ray)) / std::max(range_m_[node], 1e-6f);
  return side * side / std::max(cosine, 0.17);
}

int SurfaceGraph::Reach_px(std::size_t node) const {
  const float reach =
      NormalRadius_m(nodes_->sigma_m[node], range_m_[node] * measured_->sample_angle_rad()) /
      std::max(range_m_[node] * measured_->pixel_angle_rad, 1e-6f);
  return static_cast<int>(std::clamp(reach, kMinWindow_px, kMaxWindow_px));
}

void SurfaceGraph::LinkPixels(const Work& work) {
  const auto width = static_cast<std::size_t>(measured_->width);
  for (std::size_t k = 0; k < step_to_.size(); ++k) {
    step_to_[k] =
        std::ptrdiff_t{kNeighbourOffsets[k][0]} * measured_->width + kNeighbourOffsets[k][1];
  }
  beside_.assign(size(), 0);
  at_step_.assign(size(), 0);
  ParallelFor(static_cast<std::size_t>(measured_->height), ItemsPerChunk(10us), work,  // 640 pixels
              [&](std::size_t begin, std::size_t end) {
                RowLinks links(measured_->width);
                for (std::size_t row = begin; row < end; ++row) {
                  LinkRow(*planes_, static_cast<int>(row), links);
                  for (std::size_t column = 0; column < width; ++column) {
                    const std::int32_t node = measured_->image[row * width + column];
                    if (node < 0) continue;
                    beside_[static_cast<std::size_t>(node)] = links.linked[column];
                    at_step_[static_cast<std::size_t>(node)] = links.steps[column] != 0;
                  }
                }
              });
}

// Links cells that touch.
void SurfaceGraph::LinkCells(const Work& work) {
  constexpr std::size_t kCellsPerPiece = ItemsPerChunk(500ns);
  std::vector<std::vector<std::uint32_t>> found(size() / kCellsPerPiece + 1);
  first_link_.assign(size() + 1, 0);
  ParallelFor(size(), kCellsPerPiece, work, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t>& links = found[begin / kCellsPerPiece];
    for (std::size_t c = begin; c < end; ++c) {
      grid_->ForEachWithin(1, grid_->cell(c), [&](std::size_t other) {
        if (other != c) links.push_back(static_cast<std::uint32_t>(other));
      });
      first_link_[c + 1] = static_cast<std::uint32_t>(links.size());  // within its range of cells
    }
  });
  for (std::size_t k = 0; k < found.size(); ++k) {
    const std::size_t begin = k * kCellsPerPiece, end = std::min(begin + kCellsPerPiece, size());
    const auto before = static_cast<std::uint32_t>(links_.size());
    for (std::size_t c = begin; c < end; ++c) first_link_[c + 1] += before;
    links_.insert(links_.end(), found[k].begin(), found[k].end());
  }
}

// Pairs of cells on opposite sides, two to three cells away; two cells are the radius of a normal's
// neighbourhood (kRadius_cells of segment_scene.cc). Each cell is paired with the one nearest to
// straight across, at least 150 degrees apart.
SurfaceGraph::CellPairs SurfaceGraph::PairsOfCell(std::size_t cell) const {
  constexpr float kAcross_cos = -std::numbers::sqrt3_v<float> / 2;
  const float nearest_m2 = Squared(1.9f * grid_->edge_m());
  const float farthest_m2 = Squared(3.1f * grid_->edge_m());
  std::array<std::uint32_t, kMaxAround> around;
  std::array<Eigen::Vector3f, kMaxAround> towards;
  std::array<float, kMaxAround> best;
  std::array<std::size_t, kMaxAround> opposite;
  std::size_t count = 0;
  const bool fills_space = grid_->AnyWithin(3, grid_->cell(cell), [&](std::size_t other) {
    const Eigen::Vector3f there = nodes_->points[other] - nodes_->points[cell];
    const float distance_m2 = there.squaredNorm();
    if (distance_m2 <= nearest_m2 || distance_m2 >= farthest_m2) return false;
    if (count == kMaxAround) return true;
    around[count] = static_cast<std::uint32_t>(other);
    towards[count] = there / std::sqrt(distance_m2);
    best[count] = kAcross_cos;
    opposite[count] = count;
    ++count;
    return false;
  });
  CellPairs found;
  if (fills_space) return found;
  for (std::size_t a = 1; a < count; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const float cosine = towards[a].dot(towards[b]);
      if (cosine < best[a]) best[a] = cosine, opposite[a] = b;
      if (cosine < best[b]) best[b] = cosine, opposite[b] = a;
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    const std::uint32_t node = around[a], other = around[opposite[a]];
    if (other > node) found.pairs[found.count++] = {node, other};
  }
  return found;
}

}  // namespace cwm::perception
