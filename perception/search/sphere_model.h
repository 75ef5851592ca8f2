// A sphere's surface.
#pragma once

#include "perception/search/shape_model.h"

namespace cwm::perception {

struct SphereModel {
  using Sample = std::array<SamplePoint, 2>;
  // Shift of the centre, growth of the radius (metres).
  using Parameters = Eigen::Matrix<double, 4, 1>;
  static constexpr int kParameterCount = Parameters::RowsAtCompileTime;

  Vector3 center = Vector3::Zero();
  double radius_m = 0;
  SeenFrom side = SeenFrom::kOutside;

  // The point nearest to the lines along all normals is the centre. Two points or more.
  static std::optional<SphereModel> FromSample(std::span<const SamplePoint> sample);
  double Distance_m(const Vector3& p) const { return (p - center).norm() - radius_m; }
  Vector3 Normal(const Vector3& p) const {  // any direction at the centre
    const Vector3 q = p - center;
    const double norm = q.norm();
    return norm > 0 ? Vector3(q / norm) : Vector3(Vector3::UnitZ());
  }
  double FacingSign() const { return SignOf(side); }
  Parameters Gradient(const Vector3& p) const;
  SphereModel Moved(const Parameters& step) const;
  bool MayReach(const CellBounds& box, double gate_m) const;
  SphereModel Centred(const Vector3&) const { return *this; }
};

}  // namespace cwm::perception
