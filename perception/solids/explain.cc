#include "perception/solids/explain.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "collision/geometry/aabb.h"
#include "collision/geometry/distance_to_shape.h"
#include "perception/search/model_points.h"
#include "perception/solids/observed.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

PollEvery PollPerPoint(const Work& work) {
  return PollEvery(work, ItemsPerChunk(200ns));  // a plate with many corners takes more
}

}  // namespace

std::vector<std::int32_t> ExplainPoints(const OrientedPoints& points,
                                        const std::vector<ShapePart>& solids, const Work& work) {
  PollEvery poll = PollPerPoint(work);
  std::vector<std::int32_t> part_of_point(points.size(), kUnexplained);
  std::vector<double> nearest_m(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < solids.size(); ++k) {
    const Pose X_SL = solids[k].X_OS.inverse();
    const Aabb bounds = TightBounds(solids[k].shape, solids[k].X_OS);
    const DistanceToShape to_solid_m(solids[k]);
    for (std::size_t i = 0; i < points.size(); ++i) {
      poll();
      const Vector3 p = points.points[i].cast<double>();
      const double tolerance_m = AssignmentTolerance_m(points.sigma_m[i]);
      if (!p.allFinite() || bounds.squaredExteriorDistance(p) > tolerance_m * tolerance_m) continue;
      const double distance_m = std::abs(to_solid_m(X_SL * p));
      if (distance_m <= tolerance_m && distance_m < nearest_m[i]) {
        nearest_m[i] = distance_m;
        part_of_point[i] = static_cast<std::int32_t>(k);
      }
    }
  }
  return part_of_point;
}

void MeasureQuality(const OrientedPoints& points, const std::vector<std::int32_t>& part_of_point,
                    double spacing_m, std::vector<ShapePart>& solids, const Work& work) {
  PollEvery poll = PollPerPoint(work);
  for (std::size_t k = 0; k < solids.size(); ++k) {
    const Pose X_SL = solids[k].X_OS.inverse();
    const DistanceToShape to_solid_m(solids[k]);
    FitQuality quality = solids[k].fit.value_or(FitQuality());
    std::vector<Eigen::Vector3f> explained_S;
    double squares = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      poll();
      if (part_of_point[i] != static_cast<std::int32_t>(k)) continue;
      const Vector3 p_S = X_SL * points.points[i].cast<double>();
      const double residual_m = std::abs(to_solid_m(p_S));
      explained_S.push_back(p_S.cast<float>());
      squares += residual_m * residual_m;
      quality.max_residual_m = std::max(quality.max_residual_m, residual_m);
    }
    quality.inlier_count = static_cast<int>(explained_S.size());
    if (!explained_S.empty()) {
      const auto count = static_cast<double>(explained_S.size());
      quality.rms_m = std::sqrt(squares / count);
      quality.inlier_ratio = count / static_cast<double>(points.size());
      quality.observed_fraction =
          ObservedFraction(solids[k].shape, explained_S, CoverCell_m(spacing_m));
    }
    solids[k].fit = std::move(quality);
  }
}

}  // namespace cwm::perception
