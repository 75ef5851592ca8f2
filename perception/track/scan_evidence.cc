#include "perception/track/scan_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace cwm::perception {
namespace {

constexpr double kSigmas = 3;
// A model made of one scan and the points of another carry one warp each.
constexpr double kWarpOfBoth_m = kSlowWarp_m * std::numbers::sqrt2;
constexpr float kPointCell_m = 0.012F;      // three times the distance of thinned points
constexpr double kLargestIncidence = 0.26;  // cos 75 degrees: beyond, depths jump between pixels

}  // namespace

bool DetectedPoints::AnyWithin(const Vector3& p_W, double distance_m) const {
  if (points_W.empty()) return false;
  const Eigen::Vector3f p = p_W.cast<float>();
  const Eigen::Vector3f offset = (p - grid.Center(0)) / grid.edge_m();
  const VoxelGrid::Cell center =
      grid.cell(0) + VoxelGrid::Cell(offset.array().round().cast<int>().matrix());
  const auto squared = static_cast<float>(distance_m * distance_m);
  return grid.AnyNeighbour(center, [&](std::size_t cell) {
    const std::span<const std::uint32_t> members = grid.PointsOf(cell);
    return std::any_of(members.begin(), members.end(), [&](std::uint32_t point) {
      return (points_W[point] - p).squaredNorm() <= squared;
    });
  });
}

ScanEvidence::ScanEvidence(const PointCloud& cloud, const Pose& X_WC, const SensorNoise& noise)
    : X_CW_(X_WC.inverse()), viewpoint_W_(X_WC.translation()), noise_(noise), view_(cloud) {}

double ScanEvidence::Gate_m(const Vector3& p_W) const {
  // Depth where the optical axis is z; the range is never smaller.
  const double range_m = (p_W - viewpoint_W_).norm();
  return kSigmas * std::hypot(noise_.AxialSigma_m(range_m), kWarpOfBoth_m);
}

double ScanEvidence::Tolerance_m(const Vector3& p_W) const {
  const double range_m = (p_W - viewpoint_W_).norm();
  return ExplainedWithin_m(noise_.AxialSigma_m(range_m));
}

DetectedPoints ScanEvidence::Index(std::vector<Eigen::Vector3f> points_W) const {
  DetectedPoints indexed;
  indexed.points_W = std::move(points_W);
  for (const Eigen::Vector3f& point : indexed.points_W) {
    const Vector3 p_W = point.cast<double>();
    indexed.gates_m.push_back(Gate_m(p_W));
    indexed.tolerances_m.push_back(Tolerance_m(p_W));
    indexed.bounds_W.extend(p_W);
  }
  if (indexed.points_W.empty()) return indexed;
  indexed.grid = VoxelGrid::Build(indexed.points_W, kPointCell_m);
  return indexed;
}

bool ScanEvidence::FacesSensor(const SurfaceSample& sample, const Pose& X_WO) const {
  const Vector3 to_sensor = (viewpoint_W_ - X_WO * sample.p_O).normalized();
  const double cosine = to_sensor.dot(X_WO.linear() * sample.normal_O);
  return (sample.two_sided ? std::abs(cosine) : cosine) > kLargestIncidence;
}

RayVerdict ScanEvidence::Look(const Vector3& p_W) const {
  return view_.Look(X_CW_ * p_W, Tolerance_m(p_W));
}

std::vector<char> Explained(const std::vector<Eigen::Vector3f>& points_W,
                            const std::vector<double>& within_m, const ModelSurface& surface,
                            const Pose& X_WO) {
  const Pose X_OW = X_WO.inverse();
  std::vector<char> mask;
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    const auto nearest = surface.Nearest(X_OW * points_W[i].cast<double>());
    mask.push_back(nearest && std::abs(nearest->signed_distance_m) <= within_m[i]);
  }
  return mask;
}

double ShareOf(const std::vector<char>& mask) {
  if (mask.empty()) return 0;
  const auto count = mask.size() - std::count(mask.begin(), mask.end(), 0);
  return static_cast<double>(count) / static_cast<double>(mask.size());
}

}  // namespace cwm::perception
