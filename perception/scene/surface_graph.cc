#include "perception/scene/surface_graph.h"

#include <algorithm>
#include <numeric>

#include "perception/cloud/normals.h"
#include "perception/cloud/parallel_for.h"

namespace cwm::perception {
namespace {

std::vector<float> Ranges(const OrientedPoints& nodes, const Work& work) {
  constexpr std::size_t kNodesPerPiece = 32768;  // of 5 ns each
  std::vector<float> range_m(nodes.size());
  const Eigen::Vector3f viewpoint = nodes.viewpoint.cast<float>();
  ParallelFor(nodes.size(), kNodesPerPiece, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) range_m[i] = (nodes.points[i] - viewpoint).norm();
  });
  return range_m;
}

float Square(float x) { return x * x; }

struct CellLinks {
  std::vector<std::uint32_t> links;
  std::vector<std::array<std::uint32_t, 2>> pairs;
};

// A surface has 19 cells between two and three cells away from one of its own, the corner of a room
// three times as many. What has more fills space: nothing bends there, and its pairs would take a
// hundred times the work.
constexpr std::size_t kMostAround = 60;

// The best opposite of each node around `center`: nearest to straight across, at least 150 degrees
// apart.
std::vector<std::array<std::uint32_t, 2>> OppositePairs(const OrientedPoints& nodes,
                                                        const Eigen::Vector3f& center,
                                                        const std::vector<std::uint32_t>& around) {
  constexpr float kLeastAcross_cos = -0.866f;
  if (around.size() > kMostAround) return {};
  std::vector<Eigen::Vector3f> towards;
  towards.reserve(around.size());
  for (std::uint32_t a : around) towards.push_back((nodes.points[a] - center).normalized());
  std::vector<float> best(around.size(), kLeastAcross_cos);
  std::vector<std::size_t> opposite(around.size());
  std::iota(opposite.begin(), opposite.end(), std::size_t{0});
  for (std::size_t a = 1; a < around.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const float cosine = towards[a].dot(towards[b]);
      if (cosine < best[a]) best[a] = cosine, opposite[a] = b;
      if (cosine < best[b]) best[b] = cosine, opposite[b] = a;
    }
  }
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::size_t a = 0; a < around.size(); ++a) {
    if (around[opposite[a]] > around[a]) pairs.push_back({around[a], around[opposite[a]]});
  }
  return pairs;
}

// Cells that touch are linked. Opposite partners lie two to three cells away: two cells are one
// normal neighbourhood's radius when the cells are built for it (kRadius_cells of
// segment_scene.cc).
CellLinks LinksOfCell(const VoxelGrid& grid, const OrientedPoints& nodes, std::size_t c) {
  const float nearest_m2 = Square(1.9f * grid.edge_m()), farthest_m2 = Square(3.1f * grid.edge_m());
  CellLinks found;
  std::vector<std::uint32_t> around;
  grid.ForEachWithin(3, grid.cell(c), [&](std::size_t other) {
    if (other == c) return;
    const bool touches = (grid.cell(other) - grid.cell(c)).cwiseAbs().maxCoeff() == 1;
    if (touches) found.links.push_back(static_cast<std::uint32_t>(other));
    const float distance_m2 = (nodes.points[other] - nodes.points[c]).squaredNorm();
    if (distance_m2 > nearest_m2 && distance_m2 < farthest_m2) {
      around.push_back(static_cast<std::uint32_t>(other));
    }
  });
  found.pairs = OppositePairs(nodes, nodes.points[c], around);
  return found;
}

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
    return MeasuredPoints::kNoReturn;
  }
  return measured_
      ->image[static_cast<std::size_t>(row) * static_cast<std::size_t>(measured_->width) +
              static_cast<std::size_t>(column)];
}

double SurfaceGraph::area_m2(std::size_t node) const {
  if (grid_) return double{grid_->edge_m()} * grid_->edge_m();
  // A pixel's cone widens with the range and is cut at the angle of incidence, 80 degrees at most.
  const Eigen::Vector3f ray = nodes_->points[node] - nodes_->viewpoint.cast<float>();
  const double side = double{range_m_[node]} * measured_->pixel_angle_rad;
  const double cosine = std::abs(nodes_->normals[node].dot(ray)) / std::max(range_m_[node], 1e-6f);
  return side * side / std::max(cosine, 0.17);
}

int SurfaceGraph::Reach_px(std::size_t node) const {
  const float reach = kNormalRadius_sigma * nodes_->sigma_m[node] /
                      std::max(range_m_[node] * measured_->pixel_angle_rad, 1e-6f);
  return static_cast<int>(std::clamp(reach, 2.0f, 64.0f));
}

void SurfaceGraph::LinkPixels(const Work& work) {
  constexpr std::size_t kRowsPerPiece = 16;  // of 640 pixels, 10 us each
  const auto width = static_cast<std::size_t>(measured_->width);
  for (std::size_t k = 0; k < step_to_.size(); ++k) {
    step_to_[k] = std::ptrdiff_t{kBeside[k][0]} * measured_->width + kBeside[k][1];
  }
  beside_.assign(size(), 0);
  at_step_.assign(size(), 0);
  ParallelFor(static_cast<std::size_t>(measured_->height), kRowsPerPiece, work,
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

void SurfaceGraph::LinkCells(const Work& work) {
  std::vector<CellLinks> found(size());
  ParallelFor(size(), 64, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) found[c] = LinksOfCell(*grid_, *nodes_, c);
  });
  for (const CellLinks& f : found) {
    first_link_.push_back(static_cast<std::uint32_t>(links_.size()));
    first_pair_.push_back(static_cast<std::uint32_t>(pairs_.size()));
    links_.insert(links_.end(), f.links.begin(), f.links.end());
    pairs_.insert(pairs_.end(), f.pairs.begin(), f.pairs.end());
  }
  first_link_.push_back(static_cast<std::uint32_t>(links_.size()));
  first_pair_.push_back(static_cast<std::uint32_t>(pairs_.size()));
}

}  // namespace cwm::perception
