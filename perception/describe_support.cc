#include "perception/describe_support.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>
#include <utility>

#include "collision/geometry/signed_distance.h"
#include "perception/outline_raster.h"

namespace cwm::perception {
namespace {

// The arm's reach of the paper (section IV), above the world's floor.
constexpr double kLowestReach_m = 0.35, kHighestReach_m = 1.5;
// Wider than the pixels' spacing at the far end of a table: 4 mm at 2 m, 70 degrees of incidence.
constexpr double kObservedCell_m = 0.01;
constexpr int kPointsPerPiece = 512;  // of a microsecond or less

double Area_m2(const Plate& plate) {
  double area = std::abs(SignedArea_m2(plate.outline));
  for (const Polygon& hole : plate.holes) area -= std::abs(SignedArea_m2(hole));
  return area;
}

// The quality of a top face; what is below it is completed.
FitQuality QualityOf(const SegmentedSupport& support, const OrientedPoints& points) {
  FitQuality fit;
  const Pose X_SL = support.plate.X_FS.inverse(Eigen::Isometry);
  double squares = 0;
  std::unordered_set<std::uint64_t> cells;
  std::pair<int, int> latest{0, 0};  // points that follow each other lie mostly in one cell
  for (std::uint32_t i : support.points) {
    const Vector3 local = X_SL * points.points[i].cast<double>();
    squares += local.z() * local.z();
    fit.max_residual_m = std::max(fit.max_residual_m, std::abs(local.z()));
    const std::pair cell(static_cast<int>(std::floor(local.x() / kObservedCell_m)),
                         static_cast<int>(std::floor(local.y() / kObservedCell_m)));
    if (cell == latest && !cells.empty()) continue;
    latest = cell;
    cells.insert(std::uint64_t{static_cast<std::uint32_t>(cell.first)} << 32 |
                 static_cast<std::uint32_t>(cell.second));
  }
  fit.observed_fraction = std::min(1.0, static_cast<double>(cells.size()) * kObservedCell_m *
                                            kObservedCell_m / Area_m2(support.plate.shape));
  fit.inlier_count = static_cast<int>(support.points.size());
  fit.inlier_ratio = 1;
  fit.rms_m = std::sqrt(squares / std::max<double>(1, fit.inlier_count));
  return fit;
}

}  // namespace

DetectedSupport DescribeSupport(const SegmentedSupport& segmented, const OrientedPoints& points,
                                const Pose& X_WL, WorldFloor floor) {
  DetectedSupport support;
  support.X_WO = X_WL * segmented.plate.X_FS;
  support.point_count = static_cast<int>(segmented.points.size());
  auto model = std::make_shared<HybridModel>();
  model->point_count = support.point_count;
  model->shapes.push_back({.X_OS = Pose::Identity(),
                           .shape = segmented.plate.shape,
                           .role = PartRole::kCompleted,
                           .fit = QualityOf(segmented, points)});
  support.model = std::move(model);
  if (floor == WorldFloor::kKnown) {
    const double top = support.X_WO.translation().z();
    support.reachable = top >= kLowestReach_m && top <= kHighestReach_m;
  }
  return support;
}

std::uint64_t ExplainedBySupport(const SegmentedSupport& support, const OrientedPoints& points,
                                 const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
  const Pose X_SL = support.plate.X_FS.inverse(Eigen::Isometry);
  const OutlineRaster outline(support.plate.shape.outline);
  std::uint64_t explained = 0;
  for (std::uint32_t i : support.points) {
    poll();
    const Vector3 local = X_SL * points.points[i].cast<double>();
    const double tolerance = ExplainedWithin_m(points.sigma_m[i]);
    const Vector2 p = local.head<2>();
    if (std::abs(local.z()) > tolerance) continue;
    if (outline.Contains(p)) {
      ++explained;  // over the top face; holes hold no points of the support
    } else {
      explained += SignedDistance_m(support.plate.shape, local) <= tolerance;
    }
  }
  return explained;
}

}  // namespace cwm::perception
