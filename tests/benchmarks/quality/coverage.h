// Nothing lost: the share of the measured points that lie on geometry that the interpretation
// claims.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "tests/benchmarks/quality/claimed_geometry.h"

namespace cwm::benchmarks {

struct Coverage {
  std::int64_t points = 0;   // finite ones that were examined
  std::int64_t covered = 0;  // by any surface, or rejected and within the allowance
  // Points that are not covered: those too deep in a solid, by its claim, and those far from all
  // claims, by their label. All rejected points are among the latter, whatever the allowance.
  std::array<std::int64_t, kClaimCount> deep = {};
  enum Label { kRejected, kOfSupport, kOfObject, kLabelCount };
  std::array<std::int64_t, kLabelCount> bare = {};

  double share() const { return points == 0 ? 1 : static_cast<double>(covered) / points; }
  void Add(const Coverage& other);
};

// The largest share of the finite points that may be rejected (labelled 0) as isolated mixed
// pixels. Rejected points beyond it count as lost.
inline constexpr double kRejectable = 0.005;

// Measures every `stride`-th finite point. A point is covered if a surface lies within max(10 mm, 3
// sigma) of it and no solid contains it deeper than that.
Coverage MeasureCoverage(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                         const std::vector<std::uint32_t>& labels, std::size_t stride);

// The same for the listed points and by solids alone: the points that shapes, not meshes, explain.
Coverage CoverageBySolids(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                          const std::vector<std::uint32_t>& points);

// max(10 mm, 3 sigma) of the Kinect at the depth of the point.
double Tolerance_m(const Vector3& p_C);

}  // namespace cwm::benchmarks
