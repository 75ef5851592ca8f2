#include "perception/segmentation/up_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/cell_clusters.h"
#include "perception/segmentation/footprint.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// chosen: the largest angle between the normals of neighbouring cells of one plane.
constexpr double kSmoothPlane_rad = 10 * kDegree;
// chosen: the least share of all cells of a plane whose normal may be up; planes that are compared.
constexpr double kMinCandidateShare = 0.02;
constexpr std::size_t kMaxCandidates = 8;
// chosen: the largest angle between normals of one direction; of cells, they scatter by half.
constexpr double kSameDirection_rad = 8 * kDegree;
// chosen: a thing is at most as high as a chair's seat or a bottle on a crate; structures are
// higher, or cover more of their support.
constexpr double kMaxThing_m = 0.8;
constexpr double kMaxThingShare = 0.5;
constexpr std::size_t kMinThingCells = 3;
// derived: a cell that touches its support, as cells are cut at any height.
constexpr double kTouching_cells = 1.5;

// derived: cells this far apart touch, if the one between them has too few points.
constexpr int kBeside_cells = 2;
// chosen: the least cells of a surface that something rests on, and of what rests.
constexpr std::size_t kMinSurfaceCells = 8, kMinRestingCells = 4;
// chosen: the cosine of 20 degrees, within which cells of a surface that faces up are tilted.
constexpr float kFacesUp_cos = 0.94f;

// tuned: the weights of the evidence, by conditional logistic regression over 436 settings of
// up_benchmark (seeds 100 to 107), among them no kitchens before a rolled sensor. Fitted to half of
// them they find 0.96 to 0.98 of the other half. A smaller weight of the image finds more of the
// rolled sensors and takes the walls of kitchens for floors.
constexpr double kLevelWeight = 1.0;
constexpr double kThingsWeight = 1.0;
constexpr double kRestingWeight = 2.0;
constexpr double kImageWeight = 1.7;
constexpr double kBackwardWeight = 2.1;
// chosen: the weight of a ceiling's area, compared to a floor's: few sensors see ceilings alone.
constexpr double kHangingShare = 0.03;
// chosen: the share of a direction without planes, half of what a plane has at least.
constexpr double kNoShare = 0.01;

// A large plane. Its normal points to the side of the sensor.
struct LargePlane {
  Plane plane;
  std::vector<std::uint32_t> cells;  // on it, ascending
};

// Largest first.
std::vector<LargePlane> FindLargePlanes(const CoarseCloud& coarse) {
  const float turn_cos = static_cast<float>(std::cos(kSmoothPlane_rad));
  const std::vector<Vector3f>& normals = coarse.cells.normals;
  const auto clusters = ClusterCells(
      {coarse.grid, coarse.cells}, [&](std::uint32_t c) { return !normals[c].isZero(); },
      [&](std::uint32_t a, std::uint32_t b) { return normals[a].dot(normals[b]) >= turn_cos; });
  const double min_cells = kMinCandidateShare * static_cast<double>(coarse.cells.size());
  std::vector<LargePlane> planes;
  for (const auto& cluster : clusters) {
    if (static_cast<double>(cluster.size()) < min_cells || cluster.size() < 3) break;
    const std::optional<Plane> plane = FitPlane(coarse.cells, cluster, cluster[0]);
    if (!plane) continue;
    LargePlane large{*plane, Inliers(*plane, coarse.cells, cluster)};
    if (large.plane.Height_m(coarse.cells.viewpoint) < 0) {
      large.plane = {-large.plane.normal, -large.plane.offset_m};
    }
    planes.push_back(std::move(large));
  }
  std::ranges::stable_sort(planes, std::greater(),
                           [](const LargePlane& large) { return large.cells.size(); });
  if (planes.size() > kMaxCandidates) planes.resize(kMaxCandidates);
  return planes;
}

// The number of cells of things that stand on a plane: connected sets of cells over its footprint
// that touch it, and are neither as high nor as wide as a structure.
std::size_t CountThingCells(const CoarseCloud& coarse, const LargePlane& support) {
  const OrientedPoints& cells = coarse.cells;
  const double edge_m = coarse.grid.edge_m();
  const Footprint footprint(support.plane, cells, support.cells, edge_m);
  const auto above_m = [&](std::uint32_t c) {
    return support.plane.Height_m(cells.points[c]) -
           std::max(edge_m, kGate_sigma * cells.sigma_m[c]);
  };
  const auto clusters = ClusterCells(
      {coarse.grid, cells}, [&](std::uint32_t c) { return above_m(c) > 0; },
      [](std::uint32_t, std::uint32_t) { return true; });
  const double max_cells = kMaxThingShare * static_cast<double>(support.cells.size());
  std::size_t thing_cells = 0;
  for (const auto& cluster : clusters) {
    if (cluster.size() < kMinThingCells) break;
    if (static_cast<double>(cluster.size()) > max_cells) continue;
    double low_m = std::numeric_limits<double>::infinity(), high_m = 0;
    std::size_t over = 0;
    for (const std::uint32_t c : cluster) {
      low_m = std::min(low_m, above_m(c));
      high_m = std::max(high_m, support.plane.Height_m(cells.points[c]));
      over += footprint.Surrounds(cells.points[c].cast<double>());
    }
    const bool stands = low_m <= kTouching_cells * edge_m && high_m <= kMaxThing_m;
    if (stands && 2 * over >= cluster.size()) thing_cells += cluster.size();
  }
  return thing_cells;
}

using CellSets = std::vector<std::vector<std::uint32_t>>;

// The connected sets of cells that lie on no large plane, largest first.
CellSets SetsBetween(const std::vector<LargePlane>& planes, const CoarseCloud& coarse) {
  std::vector<char> on_plane(coarse.cells.size(), 0);
  for (const LargePlane& large : planes) {
    for (const std::uint32_t c : large.cells) on_plane[c] = 1;
  }
  CellSets sets = ClusterCells(
      {coarse.grid, coarse.cells}, [&](std::uint32_t c) { return !on_plane[c]; },
      [](std::uint32_t, std::uint32_t) { return true; });
  std::erase_if(sets, [](const auto& set) { return set.size() < kMinRestingCells; });
  return sets;
}

// One flag a cell: it is of a surface that faces up.
std::vector<char> CellsFacing(const Vector3& up, const CoarseCloud& coarse) {
  const Vector3f direction = up.cast<float>();
  const std::vector<Vector3f>& normals = coarse.cells.normals;
  const float turn_cos = static_cast<float>(std::cos(kSmoothPlane_rad));
  std::vector<char> faces(coarse.cells.size(), 0);
  for (const auto& surface : ClusterCells(
           {coarse.grid, coarse.cells},
           [&](std::uint32_t c) { return normals[c].dot(direction) > kFacesUp_cos; },
           [&](std::uint32_t a, std::uint32_t b) {
             return normals[a].dot(normals[b]) >= turn_cos;
           })) {
    if (surface.size() < kMinSurfaceCells) break;
    for (const std::uint32_t c : surface) faces[c] = 1;
  }
  return faces;
}

// True if a cell of the set's lowest layer lies beside a cell that faces up, and not below it.
bool Rests(const std::vector<std::uint32_t>& set, const Vector3& up, const std::vector<char>& faces,
           const CoarseCloud& coarse) {
  const double edge_m = coarse.grid.edge_m();
  const auto height_m = [&](std::size_t c) {
    return up.dot(coarse.cells.points[c].cast<double>());
  };
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const std::uint32_t c : set) lowest_m = std::min(lowest_m, height_m(c));
  return std::ranges::any_of(set, [&](std::uint32_t c) {
    if (height_m(c) > lowest_m + edge_m) return false;
    bool rests = false;
    coarse.grid.ForEachWithin(kBeside_cells, coarse.grid.cell(c), [&](std::size_t other) {
      rests = rests || (faces[other] && height_m(other) < height_m(c) + 0.5 * edge_m);
    });
    return rests;
  });
}

double RestingShare(const CellSets& sets, const Vector3& up, const CoarseCloud& coarse) {
  // chosen: fewer cells say nothing.
  constexpr std::size_t kMinCells = 10;
  const std::vector<char> faces = CellsFacing(up, coarse);
  std::size_t resting = 0, all = 0;
  for (const auto& set : sets) {
    all += set.size();
    if (Rests(set, up, faces, coarse)) resting += set.size();
  }
  return static_cast<double>(resting) / static_cast<double>(std::max(all, kMinCells));
}

}  // namespace

double UpEvidence::LogOdds() const {
  const double level_share = facing_share + kHangingShare * hanging_share;
  return kLevelWeight * std::log(level_share + kNoShare) +
         kThingsWeight * std::log1p(static_cast<double>(thing_cells)) +
         kRestingWeight * resting_share + kImageWeight * image_cos -
         kBackwardWeight * std::max(0.0, -forward_cos);
}

std::vector<UpEvidence> WeighUps(const CoarseCloud& coarse, const ImageAxes& axes) {
  const std::vector<LargePlane> planes = FindLargePlanes(coarse);
  const CellSets between = SetsBetween(planes, coarse);
  const double same_cos = std::cos(kSameDirection_rad);
  std::vector<UpEvidence> ups;
  for (const double side : {1.0, -1.0}) {
    for (const LargePlane& large : planes) {
      const Vector3 up = side * large.plane.normal;
      if (std::ranges::any_of(
              ups, [&](const UpEvidence& known) { return known.up.dot(up) >= same_cos; })) {
        continue;
      }
      ups.push_back({.up = up,
                     .resting_share = RestingShare(between, up, coarse),
                     .image_cos = axes.up.dot(up),
                     .forward_cos = axes.forward.dot(up)});
    }
  }
  for (UpEvidence& evidence : ups) {
    for (const LargePlane& large : planes) {
      const double cosine = large.plane.normal.dot(evidence.up);
      const double share =
          static_cast<double>(large.cells.size()) / static_cast<double>(coarse.cells.size());
      if (cosine <= -same_cos) evidence.hanging_share += share;
      if (cosine < same_cos) continue;
      evidence.facing_share += share;
      evidence.thing_cells += CountThingCells(coarse, large);
    }
  }
  std::ranges::stable_sort(ups, std::greater(), &UpEvidence::LogOdds);
  return ups;
}

ImageAxes AxesOfList(const OrientedPoints& points) {
  Vector3f sum = Vector3f::Zero();
  for (const Vector3f& p : points.points) sum += p.normalized();
  if (sum.norm() < kMinMeanRay * static_cast<float>(points.size())) {
    return {.forward = Vector3::Zero(), .up = Vector3::UnitZ(), .is_all_around = true};
  }
  const Vector3 forward = NearestAxis(sum);
  if (forward.z() != 0) return {.forward = forward, .up = -forward.z() * Vector3::UnitY()};
  if (forward.x() > 0) return {.forward = forward, .up = Vector3::UnitZ()};
  return {.forward = forward, .up = Vector3::Zero()};
}

}  // namespace cwm::perception
