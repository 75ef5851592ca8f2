// What one scan says about a surface: which points it explains, and which of it rays see, miss or
// pass through.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collision/geometry/aabb.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/voxel_grid.h"
#include "perception/track/model_surface.h"
#include "perception/track/range_view.h"

namespace cwm::perception {

// chosen: a smaller share of a surface is what completed parts, ragged borders and neighbours that
// touch make of it; a larger one is a matter of its own.
inline constexpr double kSubstantialShare = 0.25;

// Measured points of one detection, indexed by place. Finite.
struct DetectedPoints {
  std::vector<Eigen::Vector3f> points_L;
  std::vector<double> gates_m;       // per point: ScanEvidence::Gate_m
  std::vector<double> tolerances_m;  // per point: ScanEvidence::Tolerance_m
  VoxelGrid grid;
  Aabb bounds_L;

  bool AnyWithin(const Vector3& p_L, double distance_m) const;  // at most the grid's edge
};

// Immutable: one cloud, seen from one place. Tracking works in the scan's level frame L, whose axes
// are the world's and whose origin is the sensor: coordinates stay small, and floats precise,
// however far from the world's origin the sensor is.
class ScanEvidence {
 public:
  ScanEvidence(const PointCloud& cloud, const Pose& X_WC, const SensorNoise& noise);

  Pose InLevelFrame(Pose X_WO) const;  // X_LO
  Pose InWorld(Pose X_LO) const;       // X_WO

  // Two measurements of one surface agree within this distance: three standard deviations of the
  // noise of the one and of the slow warp of both.
  double Gate_m(const Vector3& p_L) const;
  // Smaller displacements may be errors of two scans: three standard deviations of the difference of
  // their slow warps, or of the noise that is left of a fit where that is more.
  double SmallestMove_m(const Vector3& p_L) const;
  // Within it a surface explains a point: ExplainedWithin_m.
  double Tolerance_m(const Vector3& p_L) const;

  DetectedPoints Index(std::vector<Eigen::Vector3f> points_L) const;

  bool FacesSensor(const SurfaceSample& sample, const Pose& X_LO) const;
  RayVerdict Look(const Vector3& p_L) const;

 private:
  Vector3 p_WL_;
  Matrix3 R_CL_;
  SensorNoise noise_;
  RangeView view_;
};

// Per point: lies within its distance `within_m` of the surface placed at X_LO.
std::vector<char> Explained(const std::vector<Eigen::Vector3f>& points_L,
                            const std::vector<double>& within_m, const ModelSurface& surface,
                            const Pose& X_LO);

// Share of non-zero entries; 0 of none.
double ShareOf(const std::vector<char>& mask);

}  // namespace cwm::perception
