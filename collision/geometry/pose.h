// Rigid transforms and vectors, in the monogram notation: X_AB is the pose of frame B in frame A,
// and p_AP = X_AB * p_BP. Metres and radians, right-handed.
#pragma once

#include <Eigen/Geometry>

namespace cwm {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

// The pose of one frame in another. Always a proper rigid transform: orthonormal, determinant +1.
using Pose = Eigen::Isometry3d;

inline Pose MakePose(const Vector3& translation_m, const Quaternion& rotation) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation.toRotationMatrix();
  pose.translation() = translation_m;
  return pose;
}

inline Pose MakeTranslation(double x_m, double y_m, double z_m) {
  return MakePose({x_m, y_m, z_m}, Quaternion::Identity());
}

// A right-handed orthonormal basis whose third column is the given unit vector. The other two
// columns are a deterministic function of it (Duff et al., "Building an Orthonormal Basis,
// Revisited", 2017).
Matrix3 BasisFromZ(const Vector3& unit_z);

// The angle of the rotation that takes one orientation to the other, in [0, pi].
double RotationAngle_rad(const Matrix3& R_A, const Matrix3& R_B);

}  // namespace cwm
