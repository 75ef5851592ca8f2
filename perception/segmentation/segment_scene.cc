#include "perception/segmentation/segment_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>

#include "absl/status/status.h"
#include "perception/cloud/downsample.h"
#include "perception/cloud/normals.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/segmentation/creases.h"
#include "perception/segmentation/join_pieces.h"
#include "perception/segmentation/level_patches.h"
#include "perception/segmentation/pieces.h"
#include "perception/segmentation/regions.h"
#include "perception/segmentation/structure_plates.h"
#include "perception/segmentation/support_planes.h"
#include "perception/segmentation/support_polygon.h"
#include "perception/segmentation/surface_graph.h"
#include "perception/segmentation/thin_things.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

using namespace std::chrono_literals;

// chosen: the cell of an unorganised cloud in standard deviations: two cells span more than half
// the radius of a normal's neighbourhood; 4 mm under Kinect noise at 0.8 m.
constexpr float kCell_sigma = 2.7f;
// chosen: a pixel at 1 m; finer cells hold single points.
constexpr float kMinCell_m = 0.002f;
// derived: cells grow until they have half of the neighbours that a cell on a surface without gaps
// has.
constexpr double kMinNeighbours = std::size(kNeighbourOffsets) / 2.0;
// chosen: the share of cells on slanted surfaces, whose points lie farther apart.
constexpr double kSlantedShare = 0.25;
// chosen: steps by a factor of 1.5 each, 25 in total.
constexpr int kMaxGrowth = 8;
// derived: the radius of normals in cells, the same as on an image.
constexpr float kRadius_cells = kNormalRadius_sigma / kCell_sigma;

// The number of neighbours of cells on slanted surfaces (a low quantile of all cells).
double Neighbours(const VoxelGrid& grid) {
  const std::size_t stride = std::max<std::size_t>(1, grid.size() / kMaxScanned);
  std::vector<double> neighbours;
  for (std::size_t c = 0; c < grid.size(); c += stride) {
    double count = -1;  // itself
    grid.ForEachWithin(1, grid.cell(c), [&](std::size_t) { ++count; });
    neighbours.push_back(count);
  }
  return Quantile(std::move(neighbours), kSlantedShare);
}

// Cells as fine as the noise allows and as coarse as the spacing of the points requires, without
// moments.
VoxelGrid FineCells(const OrientedPoints& points, const Work& work) {
  float edge = std::max(kMinCell_m, kCell_sigma * Median(points.sigma_m));
  VoxelGrid grid = VoxelGrid::BuildCells(points.points, edge, work);
  for (int k = 0; k < kMaxGrowth && Neighbours(grid) < kMinNeighbours; ++k) {
    edge *= 1.5f;
    grid = VoxelGrid::BuildCells(points.points, edge, work);
  }
  return grid;
}

// Sets sorted[i] = values[before[i]]. `sorted` may be the same vector as `before`.
template <class T>
void Gather(const std::vector<T>& values, const std::vector<std::uint32_t>& before,
            const Work& work, std::vector<T>& sorted) {
  ParallelFor(values.size(), ItemsPerChunk(10ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sorted[i] = values[before[i]];
  });
}

template <class T>
void Permute(const std::vector<std::uint32_t>& before, const Work& work, std::vector<T>& values) {
  std::vector<T> sorted(values.size());
  Gather(values, before, work, sorted);
  values = std::move(sorted);
}

// Sorts points in the order of their cells, so that later stages access memory in order for a cloud
// in any order.
void SortIntoCells(OrientedPoints& points, VoxelGrid& grid, const Work& work) {
  std::vector<std::uint32_t> before = grid.Renumber();
  Permute(before, work, points.points);
  grid.AccumulateMoments(points.points, work);
  const bool has_normals = std::any_of(points.normals.begin(), points.normals.end(),
                                       [](const Vector3f& n) { return !n.isZero(); });
  if (has_normals) Permute(before, work, points.normals);
  const bool differ = std::ranges::adjacent_find(points.sigma_m, std::ranges::not_equal_to()) !=
                      points.sigma_m.end();  // a laser's sigma is the same for all points
  if (differ) Permute(before, work, points.sigma_m);
  Gather(points.cloud_index, before, work, before);  // new pages would cost more than the copy
  points.cloud_index = std::move(before);
  // normal_sigma_rad is still zero for all points.
}

// Orientation of the level frame from up alone: z up, x along the sensor's view, projected to the
// horizontal.
Matrix3 LevelOrientation(const Vector3& up_C, const Vector3& view_C) {
  const Vector3 z = up_C.normalized();
  Vector3 x = view_C - view_C.dot(z) * z;
  if (x.norm() < 1e-3 * view_C.norm() || x.norm() == 0) return BasisFromZ(z).transpose();
  x.normalize();
  Matrix3 R_CL;
  R_CL << x, z.cross(x), z;
  return R_CL.transpose();
}

void Rotate(OrientedPoints& points, const Matrix3& R, const Work& work) {
  const Eigen::Matrix3f rotation = R.cast<float>();
  ParallelFor(points.size(), ItemsPerChunk(20ns), work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      points.points[i] = rotation * points.points[i];
      points.normals[i] = rotation * points.normals[i];
    }
  });
}

Vector3 MeanPoint(const OrientedPoints& points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3f& p : points.points) sum += p.cast<double>();
  return sum / static_cast<double>(points.size());
}

// Maps lists of nodes to lists of the measured points in them.
class NodePoints {
 public:
  NodePoints(const VoxelGrid* grid) : grid_(grid) {}
  // the points, in the order of the nodes
  std::vector<std::uint32_t> Of(const std::vector<std::uint32_t>& nodes) const {
    if (!grid_) return nodes;
    std::size_t count = 0;
    for (std::uint32_t node : nodes) count += grid_->PointsOf(node).size();
    std::vector<std::uint32_t> points;
    points.reserve(count);
    for (std::uint32_t node : nodes) {
      const auto some = grid_->PointsOf(node);
      points.insert(points.end(), some.begin(), some.end());
    }
    return points;
  }

 private:
  const VoxelGrid* grid_;
};

// Step 1: normals. Sorts the points of an unorganised cloud into cells and returns these.
std::optional<VoxelGrid> EstimateNormals(MeasuredPoints& measured, const Work& work) {
  if (measured.organised()) {
    EstimateImageNormals(measured, work);
    return std::nullopt;
  }
  VoxelGrid grid = FineCells(measured.oriented, work);
  SortIntoCells(measured.oriented, grid, work);
  EstimateGridNormals(measured.oriented, grid, kRadius_cells * grid.edge_m(), work);
  return grid;
}

struct LevelFrame {
  Matrix3 R_LC = Matrix3::Identity();
  UpSource up_source = UpSource::kGiven;
  UpVerdict up_verdict = UpVerdict::kPlausible;
  std::optional<Vector3> alternative_up_C;
};

// The level frame as given by the caller, or estimated from the scene's planes. The points are in
// frame C, or in L if `turned_to_level`.
LevelFrame FindLevelFrame(const MeasuredPoints& measured, const SegmentOptions& options,
                          bool turned_to_level, const Work& work) {
  const CoarseCloud cells = CellsForUp(measured, work);
  std::optional<ImageAxes> image;
  if (measured.organised()) image = AxesOf(measured);
  if (options.R_LC) {
    const Vector3 up =
        turned_to_level ? Vector3(Vector3::UnitZ()) : Vector3(options.R_LC->row(2).transpose());
    return {*options.R_LC, UpSource::kGiven, CheckUp(cells, up, image), std::nullopt};
  }
  LevelFrame level;
  Vector3 up = image ? image->up : Vector3(Vector3::UnitZ());
  if (options.up_C) {
    level.up_verdict = CheckUp(cells, *options.up_C, image);
    up = level.up_verdict == UpVerdict::kReversed ? Vector3(-*options.up_C) : *options.up_C;
  } else if (const std::optional<UpEstimate> estimate = EstimateUp(cells, image)) {
    level.up_source = estimate->source;
    level.alternative_up_C = estimate->alternative;
    up = estimate->up;
  } else {
    level.up_source = UpSource::kNoPlane;
  }
  level.R_LC = LevelOrientation(up, image ? image->forward : MeanPoint(measured.oriented));
  return level;
}

// The nodes of an unorganised cloud's surface: cells. The nodes of an image are its points.
struct Cells {
  VoxelGrid grid;
  OrientedPoints nodes;
};

// Step 1. Estimates normals and turns the points into the level frame. If the frame is known, it
// turns them before it makes the cells of an unorganised cloud, so that cells are made once. Sets
// `cells` for such a cloud.
LevelFrame MeasureSurface(MeasuredPoints& measured, const SegmentOptions& options, const Work& work,
                          std::optional<Cells>& cells) {
  const bool turn_first = options.R_LC && !measured.organised();
  if (turn_first) Rotate(measured.oriented, *options.R_LC, work);
  std::optional<VoxelGrid> grid = EstimateNormals(measured, work);
  options.stage_done("normals");
  work.Poll();
  const LevelFrame level = FindLevelFrame(measured, options, turn_first, work);
  if (!turn_first) Rotate(measured.oriented, level.R_LC, work);
  if (!grid) return level;
  if (!turn_first) grid = VoxelGrid::Build(measured.oriented.points, grid->edge_m(), work);
  OrientedPoints nodes = Downsample(measured.oriented, *grid, work);
  cells = {.grid = *std::move(grid), .nodes = std::move(nodes)};
  return level;
}

// The graph of neighbouring nodes and its concave creases.
struct Surface {
  SurfaceGraph graph;
  std::vector<char> crease;  // per node
};

Surface LinkNodes(const MeasuredPoints& measured, const Cells* cells, const Work& work) {
  Surface surface{cells ? SurfaceGraph::OfGrid(cells->nodes, cells->grid, work)
                        : SurfaceGraph::OfImage(measured, work),
                  {}};
  surface.crease = FindConcaveCreases(surface.graph, kConcave_rad, work);
  return surface;
}

// A sight map with cells of about two pixels.
SightMap MakeSightMap(const MeasuredPoints& measured, const Cells* cells) {
  if (!cells) return SightMap(measured.oriented, 2 * measured.pixel_angle_rad);
  std::vector<float> ranges_m;
  for (const Vector3f& p : cells->nodes.points) ranges_m.push_back(p.norm());
  const float range_m = Median(std::move(ranges_m));
  return SightMap(cells->nodes, 2 * cells->grid.edge_m() / std::max(0.1f, range_m));
}

struct Supports {
  std::vector<SupportPlane> planes;
  std::vector<Placed<Plate>> plates;  // one per plane
};

// Steps 2 to 4: planes and their plates; planes without area are dropped. `sight` is null if not
// all points were seen from one place.
Supports FindSupports(const OrientedPoints& nodes, const CoarseCloud& coarse, const SightMap* sight,
                      const Work& work) {
  Supports found;
  for (const SupportPlane& plane : FindSupportPlanes(coarse, Vector3::UnitZ(), sight, work)) {
    for (BoundedSupport& part : BoundSupport(plane, coarse, nodes, sight)) {
      found.planes.push_back(std::move(part.support));
      found.plates.push_back(std::move(part.plate));
    }
  }
  return found;
}

void BoundStructures(const SurfaceGraph& graph, const CoarseCloud& coarse, const Regions& regions,
                     const SightMap* sight, const Work& work, SegmentedScene& scene) {
  ParallelFor(regions.segments.size(), 1, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!regions.segments[k].plane) continue;
      scene.hypotheses[k].plates =
          PlatesOfStructure(regions.segments[k], coarse, graph.nodes(), sight);
    }
  });
}

// Converts results per node to results per point.
void Collect(const SurfaceGraph& graph, const Pieces& pieces, const Regions& regions,
             Supports supports, const VoxelGrid* grid, SegmentedScene& scene) {
  const NodePoints node_points(grid);
  std::vector<std::vector<std::uint32_t>> support_nodes(supports.planes.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const std::int32_t piece = pieces.of_node[i];
    if (piece >= 0 && piece < pieces.support_count) {
      support_nodes[static_cast<std::size_t>(piece)].push_back(static_cast<std::uint32_t>(i));
    }
  }
  for (std::size_t s = 0; s < supports.plates.size(); ++s) {
    scene.supports.push_back({std::move(supports.plates[s]), node_points.Of(support_nodes[s])});
  }
  for (const Segment& segment : regions.segments) {
    scene.hypotheses.push_back({.supported_by = segment.supported_by,
                                .rests_on = segment.rests_on,
                                .foot_height_m = segment.foot_height_m,
                                .points = node_points.Of(segment.nodes),
                                .node_count = segment.nodes.size(),
                                .plates = {}});
  }
  scene.rejected = node_points.Of(regions.rejected);
}

// The source of up, revised: an estimated up is confirmed if objects stand on supports that are
// level by it.
UpSource ConfirmedUpSource(const SegmentedScene& scene) {
  const bool from_plane =
      scene.up_source == UpSource::kSupport || scene.up_source == UpSource::kBarePlane;
  if (!from_plane) return scene.up_source;
  if (scene.supports.empty()) return UpSource::kBarePlane;
  const bool anything_stands = std::any_of(
      scene.hypotheses.begin(), scene.hypotheses.end(),
      [](const SegmentedHypothesis& hypothesis) { return hypothesis.supported_by >= 0; });
  return anything_stands ? UpSource::kSupport : scene.up_source;
}

// An alternative estimate of up. Only for images, which distinguish tables from walls.
std::optional<Vector3> AlternativeUp(const CoarseCloud& coarse, const MeasuredPoints& measured) {
  if (!measured.organised()) return std::nullopt;
  const std::optional<UpEstimate> estimate = EstimateUp(coarse, AxesOf(measured));
  if (!estimate || estimate->source != UpSource::kSupport) return std::nullopt;
  return estimate->up;
}

SegmentedScene SegmentInSteps(MeasuredPoints measured, const SegmentOptions& options,
                              const Work& work) {
  SegmentedScene scene;
  std::optional<Cells> cells_of_cloud;
  const LevelFrame level = MeasureSurface(measured, options, work, cells_of_cloud);
  scene.R_LC = level.R_LC;
  scene.up_source = level.up_source;
  scene.up_verdict = level.up_verdict;
  if (level.alternative_up_C) scene.alternative_up = level.R_LC * *level.alternative_up_C;
  const Cells* cells = cells_of_cloud ? &*cells_of_cloud : nullptr;
  OrientedPoints& nodes = cells_of_cloud ? cells_of_cloud->nodes : measured.oriented;

  // Supports do not depend on links, nor links on supports, so both are computed at the same time.
  std::optional<Surface> surface;
  std::optional<CoarseCloud> coarse_cloud;
  std::optional<SightMap> sight_map;
  const SightMap* from_one_place = nullptr;  // the map, if all points were seen from its viewpoint
  ReorientedCells turned;
  Supports supports;
  const auto find_supports = [&] {
    ParallelInvoke(
        work, [&] { coarse_cloud = MakeCoarseCloud(nodes, work); },
        [&] { sight_map = MakeSightMap(measured, cells); });
    const bool seen =
        measured.seen_from_origin && (!cells || IsSeenFromOnePlace(measured.oriented));
    if (seen) from_one_place = &*sight_map;
    if (from_one_place != nullptr) {
      turned = ReorientLevelPatches(Vector3f::UnitZ(), *coarse_cloud, work);
    }
    supports = FindSupports(nodes, *coarse_cloud, from_one_place, work);
  };
  ParallelInvoke(work, find_supports, [&] { surface = LinkNodes(measured, cells, work); });
  ReorientPointsOn(supports.planes, *coarse_cloud, turned, nodes);
  const SurfaceGraph& graph = surface->graph;
  const CoarseCloud& coarse = *coarse_cloud;
  const SightMap& sight = *sight_map;
  options.stage_done("supports");
  work.Poll();

  // Step 5: the objects on the supports.
  Pieces pieces =
      CutIntoPieces(graph, surface->crease, coarse, supports.planes, from_one_place, work);
  options.stage_done("clusters");
  work.Poll();
  pieces = JoinPieces(graph, std::move(pieces), from_one_place, work);
  if (from_one_place == nullptr) {
    nodes.warp_m = std::hypot(nodes.warp_m, static_cast<float>(kRegistration_m));
  }
  SeparateThinThings(graph, supports.planes, pieces, work);
  Regions regions =
      FormRegions(graph, coarse, pieces, supports.planes, supports.plates, sight, work);
  if (options.clustering == Clustering::kNone) MergeOnSupports(regions);
  options.stage_done("split");

  Collect(graph, pieces, regions, std::move(supports), cells ? &cells->grid : nullptr, scene);
  scene.up_source = ConfirmedUpSource(scene);
  // Only now it is known whether an unorganised cloud was seen from one place.
  const bool in_doubt = cells && from_one_place != nullptr && scene.up_source == UpSource::kGiven &&
                        scene.up_verdict == UpVerdict::kPlausible;
  if (in_doubt && IsSeenFromBelowAlone(coarse, Vector3::UnitZ())) {
    scene.up_verdict = UpVerdict::kSeenFromBelow;
  }
  if (scene.up_source == UpSource::kGiven && scene.supports.empty()) {
    scene.alternative_up = AlternativeUp(coarse, measured);
  }
  BoundStructures(graph, coarse, regions, from_one_place, work, scene);
  if (from_one_place != nullptr) scene.sight = *std::move(sight_map);
  scene.points = std::move(measured.oriented);
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
