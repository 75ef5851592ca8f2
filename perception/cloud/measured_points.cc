#include "perception/cloud/measured_points.h"

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "perception/cloud/image_axes.h"
#include "perception/cloud/parallel_for.h"
#include "perception/cloud/quantile.h"
#include "perception/cloud/returns.h"
#include "perception/cloud/voxel_grid.h"

namespace cwm::perception {
namespace {

using namespace std::chrono_literals;

// chosen: a cloud whose neighbouring rays are farther apart is no image (a 64-line laser has 0.01).
constexpr float kMaxPixelAngle_rad = 0.05f;
// chosen: saturated pixels are fewer; more points were measured by another sensor than told.
constexpr double kSaturatedShare = 0.01;
constexpr std::size_t kPointsPerRange = ItemsPerChunk(50ns);  // derived: one piece of work

absl::Status CheckLayout(const PointCloud& cloud) {
  if (cloud.points.empty()) {
    return absl::InvalidArgumentError("cloud.points is empty: must hold at least one point");
  }
  if (cloud.points.size() > VoxelGrid::kMaxPoints) {
    return absl::InvalidArgumentError(absl::StrCat("cloud.points has ", cloud.points.size(),
                                                   " points: must have at most ",
                                                   VoxelGrid::kMaxPoints));
  }
  if (!cloud.normals.empty() && cloud.normals.size() != cloud.points.size()) {
    return absl::InvalidArgumentError(absl::StrCat("cloud.normals has ", cloud.normals.size(),
                                                   " entries: must be empty or one per point (",
                                                   cloud.points.size(), ")"));
  }
  if (cloud.height < 1 || (cloud.organised() && cloud.width < 1)) {
    return absl::InvalidArgumentError(absl::StrCat("cloud.width x height is ", cloud.width, " x ",
                                                   cloud.height, ": must be positive"));
  }
  const auto pixels =
      static_cast<std::uint64_t>(cloud.width) * static_cast<std::uint64_t>(cloud.height);
  if (cloud.organised() && pixels != cloud.points.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("cloud.width x height is ", cloud.width, " x ", cloud.height,
                     ": must equal the number of points (", cloud.points.size(), ")"));
  }
  return absl::OkStatus();
}

float AngleBetweenRays(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The median angle over an even sample of horizontally adjacent pixels; 0 if there are none.
float MedianPixelAngle(const MeasuredPoints& measured) {
  const std::size_t stride = SampleStride(measured.image.size());
  std::vector<float> angles;
  for (std::size_t i = 1; i < measured.image.size(); i += stride) {
    if (i % static_cast<std::size_t>(measured.width) == 0) continue;
    const std::int32_t a = measured.image[i - 1], b = measured.image[i];
    if (a < 0 || b < 0) continue;
    angles.push_back(AngleBetweenRays(measured.oriented.points[static_cast<std::size_t>(a)],
                                      measured.oriented.points[static_cast<std::size_t>(b)]));
  }
  return Median(std::move(angles));
}

Eigen::Vector3f UnitOrZero(const Eigen::Vector3f& v) {
  const float norm = v.norm();
  return std::isfinite(norm) && norm > 1e-6f ? Eigen::Vector3f(v / norm) : Eigen::Vector3f::Zero();
}

bool IsTooFar(const Eigen::Vector3f& p, float farthest_m) { return p.norm() > farthest_m; }

// A range of kPointsPerRange points of a cloud.
struct Range {
  std::size_t finite = 0;
  std::size_t too_far = 0;            // of the finite
  std::size_t first = 0;              // number of measured points in the ranges before
  std::optional<std::size_t> beyond;  // the first point farther than kMaxCoordinate_m
};

std::vector<Range> CountFinite(const PointCloud& cloud, float farthest_m, const Work& work) {
  std::vector<Range> ranges((cloud.size() + kPointsPerRange - 1) / kPointsPerRange);
  ParallelFor(cloud.size(), kPointsPerRange, work, [&](std::size_t begin, std::size_t end) {
    Range& range = ranges[begin / kPointsPerRange];
    for (std::size_t i = begin; i < end; ++i) {
      if (!IsReturn(cloud.points[i])) continue;
      ++range.finite;
      range.too_far += IsTooFar(cloud.points[i], farthest_m);
      const bool is_beyond = cloud.points[i].cwiseAbs().maxCoeff() > kMaxCoordinate_m;
      if (is_beyond && !range.beyond) range.beyond = i;
    }
  });
  return ranges;
}

// The range beyond which points are left out, if they are few.
float FarthestOf(const PointCloud& cloud, const SensorNoise& noise) {
  if (!cloud.seen_from_origin) return std::numeric_limits<float>::infinity();
  return static_cast<float>(cloud.organised() ? RangeOf(noise.model).farthest_m : kWidestMap_m);
}

// Sets the places of the ranges' points; returns the number of points left out.
std::size_t PlaceRanges(std::vector<Range>& ranges, float& farthest_m) {
  std::size_t finite = 0, too_far = 0;
  for (const Range& range : ranges) {
    finite += range.finite;
    too_far += range.too_far;
  }
  const auto most = kSaturatedShare * static_cast<double>(finite);
  if (static_cast<double>(too_far) > most) farthest_m = std::numeric_limits<float>::infinity();
  const bool leaves_out = farthest_m < std::numeric_limits<float>::infinity();
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    if (leaves_out) ranges[r].finite -= ranges[r].too_far;
    if (r > 0) ranges[r].first = ranges[r - 1].first + ranges[r - 1].finite;
  }
  return leaves_out ? too_far : 0;
}

absl::Status CheckExtent(const PointCloud& cloud, const std::vector<Range>& ranges) {
  for (const Range& range : ranges) {
    if (!range.beyond) continue;
    const float largest_m = cloud.points[*range.beyond].cwiseAbs().maxCoeff();
    return absl::InvalidArgumentError(absl::StrCat("cloud.points[", *range.beyond,
                                                   "] has a coordinate of ", largest_m,
                                                   " m: must be at most ", kMaxCoordinate_m, " m"));
  }
  return absl::OkStatus();
}

void Resize(std::size_t count, OrientedPoints& points) {
  points.points.resize(count);
  points.normals.resize(count);
  points.sigma_m.resize(count);
  points.normal_sigma_rad.assign(count, 0.0f);
  points.cloud_index.resize(count);
}

struct Batch {
  std::size_t begin, end;  // indices into the cloud
  std::size_t first;       // index of its first measured point
  float farthest_m;
};

void Collect(const PointCloud& cloud, const Batch& batch, MeasuredPoints& measured) {
  OrientedPoints& out = measured.oriented;
  std::size_t k = batch.first;
  for (std::size_t i = batch.begin; i < batch.end; ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    const bool is_return = IsReturn(p) && !IsTooFar(p, batch.farthest_m);
    if (measured.organised()) {
      measured.image[i] = is_return ? static_cast<std::int32_t>(k) : kNoIndex;
    }
    if (!is_return) continue;
    out.points[k] = p;
    out.normals[k] =
        cloud.normals.empty() ? Eigen::Vector3f::Zero().eval() : UnitOrZero(cloud.normals[i]);
    out.cloud_index[k] = static_cast<std::uint32_t>(i);
    ++k;
  }
}

// Sets the noise by depth along the optical axis, whichever axis of the frame that is; by range if
// the cloud is not a camera's image.
void SetSigmas(const SensorNoise& noise, const Work& work, MeasuredPoints& measured) {
  Eigen::Vector3f forward = Eigen::Vector3f::Zero();
  if (measured.organised()) {
    const ImageAxes axes = AxesOf(measured);
    if (!axes.is_all_around) forward = axes.forward.cast<float>();
  }
  OrientedPoints& out = measured.oriented;
  ParallelFor(out.size(), kPointsPerRange, work, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float depth_m = forward.dot(out.points[i]);
      const float away_m = depth_m > 0 ? depth_m : out.points[i].norm();
      out.sigma_m[i] = static_cast<float>(noise.AxialSigma_m(away_m));
    }
  });
}

}  // namespace

absl::StatusOr<MeasuredPoints> CollectMeasured(const PointCloud& cloud, const SensorNoise& noise,
                                               const Work& work) {
  if (absl::Status status = CheckLayout(cloud); !status.ok()) return status;
  float farthest_m = FarthestOf(cloud, noise);
  std::vector<Range> ranges = CountFinite(cloud, farthest_m, work);
  if (absl::Status status = CheckExtent(cloud, ranges); !status.ok()) return status;
  MeasuredPoints measured;
  measured.beyond_range = PlaceRanges(ranges, farthest_m);
  measured.seen_from_origin = cloud.seen_from_origin;
  if (cloud.organised() && cloud.seen_from_origin) {
    measured.width = cloud.width;
    measured.height = cloud.height;
    measured.image.resize(cloud.size());
  }
  Resize(ranges.back().first + ranges.back().finite, measured.oriented);
  ParallelFor(cloud.size(), kPointsPerRange, work, [&](std::size_t begin, std::size_t end) {
    Collect(cloud, {begin, end, ranges[begin / kPointsPerRange].first, farthest_m}, measured);
  });
  OrientedPoints& out = measured.oriented;
  out.spread = noise.SpreadAboutPlanes();
  out.points_per_sample = static_cast<float>(noise.PointsPerSample());
  out.warp_m = static_cast<float>(noise.WarpSigma_m());
  if (out.points.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "cloud.points has ", cloud.size(),
        " points, none of them finite and away from the sensor: at least one must be"));
  }
  if (measured.organised()) {
    measured.pixel_angle_rad = MedianPixelAngle(measured);
    if (measured.pixel_angle_rad <= 0 || measured.pixel_angle_rad > kMaxPixelAngle_rad) {
      measured.image.clear();
    }
  }
  SetSigmas(NoiseIn(cloud, noise), work, measured);
  return measured;
}

}  // namespace cwm::perception
