// An unbounded plane.
#pragma once

#include "perception/search/shape_model.h"

namespace cwm::perception {

struct PlaneModel {
  using Sample = std::array<SamplePoint, 1>;
  // Tilt about the two basis vectors, shift along the normal (radians, radians, metres).
  enum : int { kFirstTilt, kSecondTilt, kShift };
  using Parameters = Eigen::Matrix<double, 3, 1>;
  static constexpr int kParameterCount = Parameters::RowsAtCompileTime;

  Vector3 point = Vector3::Zero();    // on the plane
  Vector3 normal = Vector3::UnitZ();  // unit, to the side that was seen

  static std::optional<PlaneModel> FromSample(std::span<const SamplePoint> sample);
  double Distance_m(const Vector3& p) const { return normal.dot(p - point); }
  Vector3 Normal(const Vector3&) const { return normal; }
  double FacingSign() const { return 1; }
  Parameters Gradient(const Vector3& p) const;
  PlaneModel Moved(const Parameters& step) const;
  bool MayReach(const CellBounds& box, double gate_m) const;
  PlaneModel Centred(const Vector3& p) const;
};

}  // namespace cwm::perception
