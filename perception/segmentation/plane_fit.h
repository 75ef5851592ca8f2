// Robust planes in sets of oriented points.
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

// chosen: pieces of one flat surface turn by no more: warp bends it.
inline constexpr double kFlat_rad = 3 * std::numbers::pi / 180;

// chosen: what has so much of the points FitPlane finds, but in one case of a hundred.
inline constexpr double kMinInlierShare = 0.4;

// chosen: rounds of refitting to those that agree: the last ones change little.
inline constexpr int kRefinements = 3;

// chosen: points of a piece, evenly spread, by which it is judged: a share of them is known to 2.5
// percent.
inline constexpr std::size_t kMaxSamples = 400;

// chosen: points of a set, evenly spread, that stand for all of it where each is asked little: a
// share of them is known to about a percent.
inline constexpr std::size_t kMaxScanned = 2000;

// The plane with the most points of `members` within 3 sigma (paper, section III step 3): sample
// consensus over triples whose normals agree with the plane that they span, refitted to its
// inliers. The normal points to the side of the members' normals. Nothing when no triple spans a
// plane. The same seed gives the same plane.
std::optional<Plane> FitPlane(const OrientedPoints& points, std::span<const std::uint32_t> members,
                              std::uint64_t seed);

// Members within 3 sigma of the plane, in their order.
std::vector<std::uint32_t> Inliers(const Plane& plane, const OrientedPoints& points,
                                   std::span<const std::uint32_t> members);

// Least squares over the members, each weighted by 1 / sigma^2, three rounds of inlier selection
// from the given start.
std::optional<Plane> RefinePlane(const Plane& start, const OrientedPoints& points,
                                 std::span<const std::uint32_t> members);

}  // namespace cwm::perception
