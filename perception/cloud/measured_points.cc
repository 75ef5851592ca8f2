#include "perception/cloud/measured_points.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "perception/cloud/quantile.h"

namespace cwm::perception {
namespace {

// Rays of neighbouring pixels farther apart than this are no image (a 64-line laser has 0.01).
constexpr float kLargestPixelAngle_rad = 0.05f;
constexpr std::size_t kAngleSamples = 4096;
constexpr int kPointsPerPiece = 8192;  // of less than 0.1 us each

absl::Status CheckLayout(const PointCloud& cloud) {
  if (cloud.points.empty()) {
    return absl::InvalidArgumentError("cloud.points is empty: must hold at least one point");
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

// Median over an even sample of horizontally adjacent pixels; 0 when there are none.
float MedianPixelAngle(const MeasuredPoints& measured) {
  const std::size_t stride = std::max<std::size_t>(1, measured.image.size() / kAngleSamples) | 1;
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

}  // namespace

absl::StatusOr<MeasuredPoints> CollectMeasured(const PointCloud& cloud, const SensorNoise& noise,
                                               const Work& work) {
  PollEvery poll(work, kPointsPerPiece);
  if (absl::Status status = CheckLayout(cloud); !status.ok()) return status;
  MeasuredPoints measured;
  OrientedPoints& out = measured.oriented;
  if (cloud.organised()) {
    measured.width = cloud.width;
    measured.height = cloud.height;
    measured.image.assign(cloud.size(), MeasuredPoints::kNoReturn);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    poll();
    const Eigen::Vector3f& p = cloud.points[i];
    if (!p.allFinite()) continue;
    if (p.cwiseAbs().maxCoeff() > kLargestCoordinate_m) {
      return absl::InvalidArgumentError(
          absl::StrCat("cloud.points[", i, "] has a coordinate of ", p.cwiseAbs().maxCoeff(),
                       " m: must be at most ", kLargestCoordinate_m, " m"));
    }
    if (cloud.organised()) measured.image[i] = static_cast<std::int32_t>(out.points.size());
    const float depth = cloud.organised() && p.z() > 0 ? p.z() : p.norm();
    out.points.push_back(p);
    out.normals.push_back(cloud.normals.empty() ? Eigen::Vector3f::Zero()
                                                : UnitOrZero(cloud.normals[i]));
    out.sigma_m.push_back(static_cast<float>(noise.AxialSigma_m(depth)));
    out.cloud_index.push_back(static_cast<std::uint32_t>(i));
  }
  if (out.points.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "cloud.points has ", cloud.size(), " points, none of them finite: at least one must be"));
  }
  out.normal_sigma_rad.assign(out.size(), 0.0f);
  if (measured.organised()) {
    measured.pixel_angle_rad = MedianPixelAngle(measured);
    if (measured.pixel_angle_rad <= 0 || measured.pixel_angle_rad > kLargestPixelAngle_rad) {
      measured.image.clear();
    }
  }
  return measured;
}

}  // namespace cwm::perception
