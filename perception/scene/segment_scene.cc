#include "perception/scene/segment_scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "absl/status/status.h"
#include "perception/cloud/normals.h"
#include "perception/scene/join_pieces.h"
#include "perception/scene/pieces.h"
#include "perception/scene/regions.h"
#include "perception/scene/support_planes.h"
#include "perception/scene/support_polygon.h"
#include "perception/scene/surface_graph.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// Cells of an unorganised cloud: two of them span half a normal neighbourhood's radius and more;
// 4 mm under Kinect noise at 0.8 m.
constexpr float kCell_sigma = 2.7f;
constexpr float kSmallestCell_m = 0.002f;
// Cells grow until a cell has this many neighbours, as on a surface without gaps (8 at most).
constexpr double kLeastNeighbours = 4;
constexpr int kMostGrowth = 8;  // times 1.5 each: 25
constexpr float kRadius_cells = 2.6f;

float MedianSigma(const OrientedPoints& points) {
  std::vector<float> sigma = points.sigma_m;
  const auto middle = sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2);
  std::nth_element(sigma.begin(), middle, sigma.end());
  return *middle;
}

double MeanNeighbours(const VoxelGrid& grid) {
  const std::size_t stride = std::max<std::size_t>(1, grid.size() / 2000);
  std::size_t neighbours = 0, asked = 0;
  for (std::size_t c = 0; c < grid.size(); c += stride, ++asked) {
    for (int n = 0; n < 27; ++n) {
      const VoxelGrid::Cell d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      neighbours += n != 13 && grid.Find(grid.cell(c) + d) != VoxelGrid::kNone;
    }
  }
  return static_cast<double>(neighbours) / static_cast<double>(asked);
}

// As fine as the noise allows, as coarse as the spacing of the points asks.
VoxelGrid FineGrid(const OrientedPoints& points) {
  float edge = std::max(kSmallestCell_m, kCell_sigma * MedianSigma(points));
  VoxelGrid grid = VoxelGrid::Build(points.points, edge);
  for (int k = 0; k < kMostGrowth && MeanNeighbours(grid) < kLeastNeighbours; ++k) {
    edge *= 1.5f;
    grid = VoxelGrid::Build(points.points, edge);
  }
  return grid;
}

// Level frame from up alone: z up, x along the sensor's view, projected to the horizontal.
Matrix3 LevelOrientation(const Vector3& up_C, const Vector3& view_C) {
  const Vector3 z = up_C.normalized();
  Vector3 x = view_C - view_C.dot(z) * z;
  if (x.norm() < 1e-3 * view_C.norm() || x.norm() == 0) return BasisFromZ(z).transpose();
  x.normalize();
  Matrix3 R_CL;
  R_CL << x, z.cross(x), z;
  return R_CL.transpose();
}

void Rotate(OrientedPoints& points, const Matrix3& R) {
  const Eigen::Matrix3f rotation = R.cast<float>();
  for (Vector3f& p : points.points) p = rotation * p;
  for (Vector3f& n : points.normals) n = rotation * n;
}

Vector3 MeanPoint(const OrientedPoints& points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3f& p : points.points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

// Measured points per node, so that nodes' results become points' results.
class NodePoints {
 public:
  NodePoints(const VoxelGrid* grid) : grid_(grid) {}
  std::vector<std::uint32_t> Of(const std::vector<std::uint32_t>& nodes) const {
    if (!grid_) return nodes;
    std::vector<std::uint32_t> points;
    for (std::uint32_t node : nodes) {
      const auto some = grid_->PointsOf(node);
      points.insert(points.end(), some.begin(), some.end());
    }
    std::sort(points.begin(), points.end());
    return points;
  }

 private:
  const VoxelGrid* grid_;
};

struct Built {
  std::vector<SupportPlane> planes;
  std::vector<Placed<Plate>> plates;
};

// Plates of all supports; planes that span no area are dropped with their plate.
Built BuildPlates(const CoarseCloud& coarse, std::vector<SupportPlane> planes) {
  Built built;
  for (SupportPlane& support : planes) {
    std::optional<Placed<Plate>> plate =
        MakeSupportPlate(support.plane, coarse.cells, support.cells);
    if (!plate) continue;
    built.planes.push_back(std::move(support));
    built.plates.push_back(std::move(*plate));
  }
  return built;
}

SegmentedScene SegmentInSteps(MeasuredPoints measured, const SegmentOptions& options,
                              const Work& work) {
  SegmentedScene scene;
  OrientedPoints& points = measured.oriented;

  // Step 1: normals.
  std::optional<VoxelGrid> grid;
  if (measured.organised()) {
    EstimateImageNormals(measured, work);
  } else {
    grid = FineGrid(points);
    EstimateGridNormals(points, *grid, kRadius_cells * grid->edge_m(), work);
  }
  options.stage_done("normals");
  work.Poll();

  // The level frame, given or told by the largest plane.
  const Vector3 view_C = measured.organised() ? Vector3(Vector3::UnitZ()) : MeanPoint(points);
  if (options.R_LC) {
    scene.R_LC = *options.R_LC;
  } else {
    std::optional<Vector3> up = options.up_C;
    if (!up) up = EstimateUp(MakeCoarseCloud(points), measured.organised());
    scene.up_known = up.has_value();
    if (!up) up = measured.organised() ? Vector3(-Vector3::UnitY()) : Vector3(Vector3::UnitZ());
    scene.R_LC = LevelOrientation(*up, view_C);
  }
  Rotate(points, scene.R_LC);
  if (grid) grid = VoxelGrid::Build(points.points, grid->edge_m());
  const SurfaceGraph graph =
      grid ? SurfaceGraph::OfGrid(points, *grid, work) : SurfaceGraph::OfImage(measured);

  // Steps 2 to 4: supports.
  const CoarseCloud coarse = MakeCoarseCloud(graph.nodes());
  Built built = BuildPlates(coarse, FindSupportPlanes(coarse, Vector3::UnitZ(), work));
  options.stage_done("supports");
  work.Poll();

  // Step 5: what stands on them.
  Pieces pieces = CutIntoPieces(graph, coarse, built.planes, work);
  options.stage_done("clusters");
  work.Poll();
  const float pitch =
      measured.organised()
          ? 2 * measured.pixel_angle_rad
          : 2 * grid->edge_m() / std::max(0.1f, static_cast<float>(MeanPoint(points).norm()));
  const SightMap sight(graph.nodes(), pitch);
  pieces = JoinPieces(graph, std::move(pieces), sight);
  Regions regions = FormRegions(graph, coarse, pieces, built.planes, built.plates, sight);
  options.stage_done("split");

  const NodePoints node_points(grid ? &*grid : nullptr);
  std::vector<std::vector<std::uint32_t>> support_nodes(built.planes.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const std::int32_t piece = pieces.of_node[i];
    if (piece >= 0 && piece < pieces.support_count) {
      support_nodes[static_cast<std::size_t>(piece)].push_back(static_cast<std::uint32_t>(i));
    }
  }
  for (std::size_t s = 0; s < built.planes.size(); ++s) {
    scene.supports.push_back({std::move(built.plates[s]), node_points.Of(support_nodes[s])});
  }
  for (const Segment& segment : regions.segments) {
    scene.things.push_back({segment.supported_by, node_points.Of(segment.nodes)});
  }
  scene.rejected = node_points.Of(regions.rejected);
  scene.points = std::move(points);
  return scene;
}

}  // namespace

absl::StatusOr<SegmentedScene> SegmentScene(MeasuredPoints measured, const SegmentOptions& options,
                                            const Work& work) {
  try {
    return SegmentInSteps(std::move(measured), options, work);
  } catch (const Stopped& stopped) {
    return absl::CancelledError(stopped.what());
  }
}

}  // namespace cwm::perception
