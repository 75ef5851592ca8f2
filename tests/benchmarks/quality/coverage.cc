#include "tests/benchmarks/quality/coverage.h"

#include <algorithm>
#include <cmath>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/triangle.h"
#include "perception/cloud/sensor_noise.h"
#include "tests/benchmarks/quality/cell_index.h"

namespace cwm::benchmarks {
namespace {

enum class Where { kNowhere, kOnSurface, kDeepInside };

struct Place {
  Where where = Where::kNowhere;
  Claim claim = Claim::kSupport;  // of the solid that contains it too deep
};

Place PlaceAmongSolids(const std::vector<ClaimedSolid>& solids, const Vector3& p_C,
                       double tolerance_m) {
  Place place;
  for (const ClaimedSolid& solid : solids) {
    if (solid.bounds_C.squaredExteriorDistance(p_C) > tolerance_m * tolerance_m) continue;
    const double distance_m = SignedDistance_m(solid.shape, solid.X_CS.inverse() * p_C);
    if (distance_m < -tolerance_m) return {Where::kDeepInside, solid.claim};
    if (distance_m <= tolerance_m) place.where = Where::kOnSurface;
  }
  return place;
}

Coverage::Label LabelKind(std::uint32_t label) {
  constexpr std::uint32_t kLastSupport = 9;  // as SceneInterpretation::labels says
  if (label == 0) return Coverage::kRejected;
  return label <= kLastSupport ? Coverage::kOfSupport : Coverage::kOfObject;
}

class Triangles {
 public:
  explicit Triangles(const std::vector<ClaimedTriangle>& triangles) : triangles_(triangles) {
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      Aabb bounds;
      for (const Vector3& corner : triangles[t].corners_C) bounds.extend(corner);
      index_.Insert(bounds, t);
    }
  }

  bool AnyWithin(const Vector3& p_C, double distance_m) const {
    return index_.AnyNear(p_C, distance_m, [&](std::uint32_t t) {
      const auto& [a, b, c] = triangles_[t].corners_C;
      return (NearestOnTriangle(a, b, c, p_C) - p_C).norm() <= distance_m;
    });
  }

 private:
  const std::vector<ClaimedTriangle>& triangles_;
  CellIndex index_;
};

}  // namespace

double Tolerance_m(const Vector3& p_C) {
  constexpr double kMin_m = 0.010;
  return std::max(kMin_m, 3 * perception::SensorNoise{}.AxialSigma_m(p_C.z()));
}

void Coverage::Add(const Coverage& other) {
  points += other.points;
  covered += other.covered;
  for (std::size_t c = 0; c < deep.size(); ++c) deep[c] += other.deep[c];
  for (std::size_t l = 0; l < bare.size(); ++l) bare[l] += other.bare[l];
}

Coverage MeasureCoverage(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                         const std::vector<std::uint32_t>& labels, std::size_t stride) {
  const Triangles triangles(claims.triangles);
  Coverage coverage;
  std::int64_t rejected = 0;
  std::size_t finite = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.points[i].allFinite() || finite++ % stride != 0) continue;
    ++coverage.points;
    const Vector3 p_C = cloud.points[i].cast<double>();
    const double tolerance_m = Tolerance_m(p_C);
    const Place place = PlaceAmongSolids(claims.solids, p_C, tolerance_m);
    const bool covered = place.where == Where::kOnSurface ||
                         (place.where == Where::kNowhere && triangles.AnyWithin(p_C, tolerance_m));
    coverage.covered += covered;
    rejected += !covered && labels[i] == 0;
    if (covered) continue;
    if (place.where == Where::kDeepInside) {
      ++coverage.deep[static_cast<std::size_t>(place.claim)];
    } else {
      ++coverage.bare[LabelKind(labels[i])];
    }
  }
  const auto allowance =
      static_cast<std::int64_t>(kRejectable * static_cast<double>(coverage.points));
  coverage.covered += std::min(rejected, allowance);
  return coverage;
}

Coverage CoverageBySolids(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                          const std::vector<std::uint32_t>& points) {
  Coverage coverage;
  for (std::uint32_t i : points) {
    const Vector3 p_C = cloud.points[i].cast<double>();
    if (!p_C.allFinite()) continue;
    ++coverage.points;
    coverage.covered +=
        PlaceAmongSolids(claims.solids, p_C, Tolerance_m(p_C)).where == Where::kOnSurface;
  }
  return coverage;
}

}  // namespace cwm::benchmarks
