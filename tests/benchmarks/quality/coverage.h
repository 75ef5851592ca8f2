// Nothing lost: how many of the measured points lie on what the interpretation claims.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "tests/benchmarks/quality/claimed_geometry.h"

namespace cwm::benchmarks {

struct Coverage {
  std::int64_t points = 0;   // finite ones that were looked at
  std::int64_t covered = 0;  // by any surface, or rejected and within the allowance
  // Of those that are not, by the claim that holds them too deep; and those that no claim is near,
  // by what they are labelled as. What is rejected is among the latter, whatever the allowance.
  std::array<std::int64_t, kClaimCount> deep = {};
  enum Label { kRejected, kOfSupport, kOfThing, kLabelCount };
  std::array<std::int64_t, kLabelCount> bare = {};

  double share() const { return points == 0 ? 1 : static_cast<double>(covered) / points; }
  void Add(const Coverage& other);
};

// Isolated mixed pixels may be rejected, labelled 0: this share of the finite points at most. What
// is rejected beyond it is lost.
inline constexpr double kRejectable = 0.005;

// A point is covered when a surface lies within max(10 mm, 3 sigma) of it and no solid holds it
// deeper than that. Of every `stride`-th finite point.
Coverage MeasureCoverage(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                         const std::vector<std::uint32_t>& labels, std::size_t stride);

// The same of the listed points, by solids alone: what shapes explain and meshes do not.
Coverage CoverageBySolids(const ClaimedGeometry& claims, const perception::PointCloud& cloud,
                          const std::vector<std::uint32_t>& points);

// max(10 mm, 3 sigma) of the Kinect at the depth of the point.
double Tolerance_m(const Vector3& p_C);

}  // namespace cwm::benchmarks
