#include "perception/describe_support.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "collision/geometry/signed_distance.h"
#include "perception/cloud/tolerances.h"
#include "perception/outline_raster.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// cited: the reach of the paper's arm (section IV), above the world's floor.
constexpr double kMinReach_m = 0.35, kMaxReach_m = 1.5;
// derived: the least number of points per cell; cells are widened until nearly all have it. Of
// randomly distributed points, 1 cell in 500 then stays empty.
constexpr std::uint32_t kMinInCell = 4;
// chosen: the least number of cells; wider ones would be as wide as the face.
constexpr std::size_t kMinCells = 64;

double Area_m2(const Plate& plate) {
  double area = std::abs(SignedArea_m2(plate.outline));
  for (const Polygon& hole : plate.holes) area -= std::abs(SignedArea_m2(hole));
  return area;
}

// The number of points per cell of a top face. The finest cells are three pixels of a Kinect at 2
// m.
class Occupancy {
 public:
  // Adds a point. Consecutive points are mostly in one cell.
  void Add(const Vector3& local) {
    const Cell cell(static_cast<std::int32_t>(std::floor(local.x() / cell_m_)),
                    static_cast<std::int32_t>(std::floor(local.y() / cell_m_)));
    if (latest_ == nullptr || cell != latest_cell_) {
      latest_ = &counts_[KeyOf(cell)];
      latest_cell_ = cell;
    }
    ++*latest_;
  }

  std::size_t cells() const { return counts_.size(); }
  double Area_m2() const { return static_cast<double>(counts_.size()) * cell_m_ * cell_m_; }

  bool IsSparse() const {
    const auto dense = std::count_if(counts_.begin(), counts_.end(),
                                     [](const auto& entry) { return entry.second >= kMinInCell; });
    return static_cast<double>(dense) < kNearlyAll * static_cast<double>(counts_.size());
  }

  // The same points in cells of twice the width.
  Occupancy Coarser() const {
    Occupancy coarser;
    coarser.cell_m_ = 2 * cell_m_;
    for (const auto& [key, count] : counts_) {
      const Cell cell(static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key));
      coarser.counts_[KeyOf({cell.first >> 1, cell.second >> 1})] += count;
    }
    return coarser;
  }

 private:
  using Cell = std::pair<std::int32_t, std::int32_t>;
  static std::uint64_t KeyOf(const Cell& cell) {
    return std::uint64_t{static_cast<std::uint32_t>(cell.first)} << 32 |
           static_cast<std::uint32_t>(cell.second);
  }

  double cell_m_ = kFootprintCell_m;
  std::unordered_map<std::uint64_t, std::uint32_t> counts_;
  std::uint32_t* latest_ = nullptr;  // the count of latest_cell_
  Cell latest_cell_;
};

// The area that points cover, in square metres, in cells as narrow as the points allow.
double ObservedArea_m2(Occupancy occupancy) {
  while (occupancy.IsSparse() && occupancy.cells() >= kMinCells) occupancy = occupancy.Coarser();
  return occupancy.Area_m2();
}

// The quality of a top face; the plate below it is completed.
FitQuality QualityOf(const SegmentedSupport& support, const OrientedPoints& points) {
  FitQuality fit;
  const Pose X_SL = support.plate.X_FS.inverse(Eigen::Isometry);
  double squares = 0;
  Occupancy occupancy;
  for (std::uint32_t i : support.points) {
    const Vector3 local = X_SL * points.points[i].cast<double>();
    squares += local.z() * local.z();
    fit.max_residual_m = std::max(fit.max_residual_m, std::abs(local.z()));
    occupancy.Add(local);
  }
  const double face_m2 = Area_m2(support.plate.shape);
  fit.observed_fraction = std::min(1.0, ObservedArea_m2(std::move(occupancy)) / face_m2);
  fit.inlier_count = static_cast<int>(support.points.size());
  fit.inlier_ratio = 1;
  fit.rms_m = std::sqrt(squares / std::max<double>(1, fit.inlier_count));
  return fit;
}

SurfacePart SurfaceOf(Surface surface, const Pose& X_SL, std::size_t points) {
  for (Vector3& v : surface.mesh.vertices) v = X_SL * v;
  return {MakeMesh(std::move(surface.mesh)), static_cast<int>(points)};
}

}  // namespace

DescribedSupport DescribeSupport(const SegmentedSupport& segmented, const OrientedPoints& points,
                                 const Pose& X_WL, WorldFloor floor, const SurfaceOptions& options,
                                 const Work& work) {
  DescribedSupport described;
  DetectedSupport& support = described.support;
  support.X_WO = X_WL * segmented.plate.X_FS;
  support.point_count = static_cast<int>(segmented.points.size());
  auto model = std::make_shared<HybridModel>();
  model->point_count = support.point_count;
  model->shapes.push_back({.X_OS = Pose::Identity(),
                           .shape = segmented.plate.shape,
                           .role = PartRole::kCompleted,
                           .fit = QualityOf(segmented, points)});
  const std::vector<std::uint32_t> beyond = PointsBeyondPlate(segmented, points, work);
  described.explained = segmented.points.size() - beyond.size();
  Surface rest = ReconstructSurface(Subset(points, beyond), options, work);
  described.explained += rest.explained.size();
  if (!rest.mesh.triangles.empty()) {
    const Pose X_SL = segmented.plate.X_FS.inverse(Eigen::Isometry);
    model->surfaces.push_back(SurfaceOf(std::move(rest), X_SL, beyond.size()));
  }
  support.model = std::move(model);
  if (floor == WorldFloor::kKnown) {
    const double top = support.X_WO.translation().z();
    support.reachable = top >= kMinReach_m && top <= kMaxReach_m;
  }
  return described;
}

std::vector<std::uint32_t> PointsBeyondPlate(const SegmentedSupport& support,
                                             const OrientedPoints& points, const Work& work) {
  PollEvery poll(work, ItemsPerChunk(1us));
  const Pose X_SL = support.plate.X_FS.inverse(Eigen::Isometry);
  const OutlineRaster outline(support.plate.shape.outline);
  std::vector<std::uint32_t> beyond;
  for (std::uint32_t i : support.points) {
    poll();
    const Vector3 local = X_SL * points.points[i].cast<double>();
    const double tolerance = ExplainedWithin_m(points.sigma_m[i]);
    // Tests the top face first; holes contain no points of the support.
    const bool near_top = std::abs(local.z()) <= tolerance;
    if (near_top && outline.Contains(local.head<2>())) continue;
    if (near_top && SignedDistance_m(support.plate.shape, local) <= tolerance) continue;
    beyond.push_back(i);
  }
  return beyond;
}

}  // namespace cwm::perception
