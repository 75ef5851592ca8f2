// The evidence of one scan about a surface: which points it explains, and what rays saw of it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collision/geometry/aabb.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/track/model_surface.h"
#include "perception/track/range_view.h"

namespace cwm::perception {

// chosen: completed parts, ragged borders and touching neighbours account for smaller shares of a
// surface; a larger share is significant.
inline constexpr double kSubstantialShare = 0.25;

// The measured points of one detection, indexed by place. All are finite.
struct DetectedPoints {
  std::vector<Eigen::Vector3f> points_L;
  std::vector<double> gates_m;       // per point: ScanEvidence::Gate_m
  std::vector<double> tolerances_m;  // per point: ScanEvidence::Tolerance_m
  VoxelGrid grid;
  Aabb bounds_L;

  bool AnyWithin(const Vector3& p_L, double distance_m) const;  // up to the grid's edge
};

// Immutable: one cloud. Unless it was seen from the origin of C, its rays are no evidence, and all
// their verdicts are kUnknown. Tracking works in the scan's level frame L, with the
// world's axes and its origin at the sensor: coordinates stay small, and floats precise, at any
// distance from the world's origin.
class ScanEvidence {
 public:
  ScanEvidence(const PointCloud& cloud, const Pose& X_WC, const SensorNoise& noise,
               bool seen_from_origin = true);

  Pose InLevelFrame(Pose X_WO) const;  // X_LO
  Pose InWorld(Pose X_LO) const;       // X_WO

  // The distance within which two measurements of one surface agree, in metres: three standard
  // deviations of the noise of one and the slow warp of both.
  double Gate_m(const Vector3& p_L) const;
  // The least displacement that is not an error of two scans, in metres: three standard deviations
  // of the difference of their slow warps, or of the residual noise of a fit if that is more.
  double SmallestMove_m(const Vector3& p_L) const;
  // The distance within which a surface explains a point, in metres: ExplainedWithin_m.
  double Tolerance_m(const Vector3& p_L) const;

  DetectedPoints Index(std::vector<Eigen::Vector3f> points_L) const;

  bool FacesSensor(const SurfaceSample& sample, const Pose& X_LO) const;
  RayVerdict VerdictAt(const Vector3& p_L) const;

 private:
  Vector3 p_WL_;
  Matrix3 R_CL_;
  SensorNoise noise_;
  std::optional<RangeView> view_;  // empty: not seen from the origin
};

// Per point, whether it is within its distance `within_m` of the surface placed at X_LO.
std::vector<char> Explained(const std::vector<Eigen::Vector3f>& points_L,
                            const std::vector<double>& within_m, const ModelSurface& surface,
                            const Pose& X_LO);

// Share of non-zero entries; 0 if empty.
double ShareOf(const std::vector<char>& mask);

}  // namespace cwm::perception
