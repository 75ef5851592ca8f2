#include "collision/geometry/pose.h"

#include <cmath>

namespace cwm {

Matrix3 BasisFromZ(const Vector3& unit_z) {
  const double sign = std::copysign(1.0, unit_z.z());
  const double a = -1.0 / (sign + unit_z.z());
  const double b = unit_z.x() * unit_z.y() * a;
  Matrix3 basis;
  basis.col(0) << 1.0 + sign * unit_z.x() * unit_z.x() * a, sign * b, -sign * unit_z.x();
  basis.col(1) << b, sign + unit_z.y() * unit_z.y() * a, -unit_z.y();
  basis.col(2) = unit_z;
  return basis;
}

double RotationAngle_rad(const Matrix3& R_A, const Matrix3& R_B) {
  // Sine and cosine together stay accurate near 0 and pi, where acos of the trace does not.
  const Matrix3 R_AB = R_A.transpose() * R_B;
  const Vector3 twice_sine_axis(R_AB(2, 1) - R_AB(1, 2), R_AB(0, 2) - R_AB(2, 0),
                                R_AB(1, 0) - R_AB(0, 1));
  return std::atan2(twice_sine_axis.norm(), R_AB.trace() - 1.0);
}

}  // namespace cwm
