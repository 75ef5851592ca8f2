#include "perception/track/scan_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// derived: the model of one scan and the points of another have one warp each.
constexpr double kOfBoth = std::numbers::sqrt2;
// derived: cells of about three by three thinned points.
constexpr double kPointCell_m = kThinningSpacing_m * 3;

}  // namespace

bool DetectedPoints::AnyWithin(const Vector3& p_L, double distance_m) const {
  if (points_L.empty()) return false;
  const Eigen::Vector3f p = p_L.cast<float>();
  const Eigen::Vector3f offset = (p - grid.Center(0)) / grid.edge_m();
  const VoxelGrid::Cell center =
      grid.cell(0) + VoxelGrid::Cell(offset.array().round().cast<int>().matrix());
  const auto squared = static_cast<float>(distance_m * distance_m);
  return grid.AnyWithin(1, center, [&](std::size_t cell) {
    const std::span<const std::uint32_t> members = grid.PointsOf(cell);
    return std::any_of(members.begin(), members.end(), [&](std::uint32_t point) {
      return (points_L[point] - p).squaredNorm() <= squared;
    });
  });
}

ScanEvidence::ScanEvidence(const PointCloud& cloud, const Pose& X_WC, const SensorNoise& noise,
                           bool seen_from_origin)
    : p_WL_(X_WC.translation()), R_CL_(X_WC.linear().transpose()), noise_(NoiseIn(cloud, noise)) {
  if (seen_from_origin) view_.emplace(cloud);
}

Pose ScanEvidence::InLevelFrame(Pose X_WO) const {
  X_WO.translation() -= p_WL_;
  return X_WO;
}

Pose ScanEvidence::InWorld(Pose X_LO) const {
  X_LO.translation() += p_WL_;
  return X_LO;
}

double ScanEvidence::Gate_m(const Vector3& p_L) const {
  // The range is at least the depth that the noise depends on.
  const double range_m = p_L.norm();
  return kGate_sigma * std::hypot(noise_.AxialSigma_m(range_m), kOfBoth * noise_.WarpSigma_m());
}

double ScanEvidence::SmallestMove_m(const Vector3& p_L) const {
  // With fewer samples an object could not be distinguished from others.
  const double fit_sigma_m = noise_.AxialSigma_m(p_L.norm()) / std::sqrt(kMinInformed);
  return kGate_sigma * kOfBoth * std::max(fit_sigma_m, noise_.WarpSigma_m());
}

double ScanEvidence::Tolerance_m(const Vector3& p_L) const {
  return ExplainedWithin_m(noise_.AxialSigma_m(p_L.norm()));
}

DetectedPoints ScanEvidence::Index(std::vector<Eigen::Vector3f> points_L) const {
  DetectedPoints indexed;
  indexed.points_L = std::move(points_L);
  for (const Eigen::Vector3f& point : indexed.points_L) {
    const Vector3 p_L = point.cast<double>();
    indexed.gates_m.push_back(Gate_m(p_L));
    indexed.tolerances_m.push_back(Tolerance_m(p_L));
    indexed.bounds_L.extend(p_L);
  }
  if (indexed.points_L.empty()) return indexed;
  indexed.grid = VoxelGrid::Build(indexed.points_L, static_cast<float>(kPointCell_m));
  return indexed;
}

bool ScanEvidence::FacesSensor(const SurfaceSample& sample, const Pose& X_LO) const {
  const Vector3 to_sensor = -(X_LO * sample.p_O).normalized();
  const double cosine = to_sensor.dot(X_LO.linear() * sample.normal_O);
  // Surfaces seen more edge-on than the error of their normals may face away, and ranges jump
  // between their pixels.
  return (sample.two_sided ? std::abs(cosine) : cosine) > kNormalMiss_sin;
}

RayVerdict ScanEvidence::VerdictAt(const Vector3& p_L) const {
  return view_ ? view_->VerdictAt(R_CL_ * p_L, Tolerance_m(p_L)) : RayVerdict::kUnknown;
}

std::vector<char> Explained(const std::vector<Eigen::Vector3f>& points_L,
                            const std::vector<double>& within_m, const ModelSurface& surface,
                            const Pose& X_LO) {
  const Pose X_OL = X_LO.inverse();
  std::vector<char> mask;
  for (std::size_t i = 0; i < points_L.size(); ++i) {
    const auto nearest = surface.Nearest(X_OL * points_L[i].cast<double>(), within_m[i]);
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
