// Robust fits of planes to sets of oriented points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"
#include "perception/cloud/oriented_points.h"

namespace cwm::perception {

// All points p with normal . p = offset_m.
struct Plane {
  Vector3 normal = Vector3::UnitZ();  // unit
  double offset_m = 0;

  double Height_m(const Vector3& p) const { return normal.dot(p) - offset_m; }
  double Height_m(const Eigen::Vector3f& p) const { return Height_m(Vector3(p.cast<double>())); }
};

// chosen: the largest angle between pieces of one flat surface, which warp bends.
inline constexpr double kFlat_rad = 3 * std::numbers::pi / 180;

// chosen: the least share of points of a plane that FitPlane finds in 99 of 100 cases.
inline constexpr double kMinInlierShare = 0.4;

// chosen: rounds of refitting to the inliers; the last rounds change little.
inline constexpr int kRefinements = 3;

// chosen: evenly spread points of a piece that represent it in a test; a share of them is known to
// 2.5 percent.
inline constexpr std::size_t kMaxSamples = 400;

// chosen: evenly spread points of a set that represent it where the test of each is cheap; a share
// of them is known to about a percent.
inline constexpr std::size_t kMaxScanned = 2000;

// The plane with the most points of `members` within 3 sigma (paper, section III step 3): sample
// consensus over triples whose normals agree with the plane through them, refitted to its inliers.
// The normal points to the side of the members' normals. Empty if no triple determines a plane. The
// same seed gives the same plane.
std::optional<Plane> FitPlane(const OrientedPoints& points, std::span<const std::uint32_t> members,
                              std::uint64_t seed);

// The members within 3 sigma of the plane, in their order.
std::vector<std::uint32_t> Inliers(const Plane& plane, const OrientedPoints& points,
                                   std::span<const std::uint32_t> members);

// Refits the plane by least squares over its inliers, weighted by 1 / sigma^2, in three rounds of
// inlier selection. Empty if the inliers do not determine a plane.
std::optional<Plane> RefinePlane(const Plane& start, const OrientedPoints& points,
                                 std::span<const std::uint32_t> members);

}  // namespace cwm::perception
