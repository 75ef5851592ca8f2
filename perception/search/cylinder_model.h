// A cylinder's lateral surface: a cone of slope 0, with one parameter less.
#pragma once

#include <algorithm>
#include <cmath>

#include "perception/search/cone_model.h"
#include "perception/search/shape_model.h"

namespace cwm::perception {

struct CylinderModel {
  using Sample = std::array<SamplePoint, 2>;
  // The cone's parameters without the slope.
  using Parameters = Eigen::Matrix<double, ConeModel::kSlope, 1>;
  static constexpr int kParameterCount = Parameters::RowsAtCompileTime;
  static constexpr int kFirstTilt = ConeModel::kFirstTilt;

  Vector3 point = Vector3::Zero();  // on the axis
  Vector3 axis = Vector3::UnitZ();  // unit
  double radius_m = 0;
  SeenFrom side = SeenFrom::kOutside;

  // The axis is normal to both normals.
  static std::optional<CylinderModel> FromSample(std::span<const SamplePoint> sample);
  // The cylinder around a known axis direction, from two points or more.
  static std::optional<CylinderModel> AroundAxis(std::span<const SamplePoint> sample,
                                                 const Vector3& axis);
  double Distance_m(const Vector3& p) const {
    const Vector3 x = p - point;
    const double height_m = axis.dot(x);
    return std::sqrt(std::max(0.0, x.squaredNorm() - height_m * height_m)) - radius_m;
  }
  Vector3 Normal(const Vector3& p) const { return AsCone().Normal(p); }
  double FacingSign() const { return SignOf(side); }
  Parameters Gradient(const Vector3& p) const {
    return AsCone().Gradient(p).head<kParameterCount>();
  }
  CylinderModel Moved(const Parameters& step) const;
  bool MayReach(const CellBounds& box, double gate_m) const {
    return AsCone().MayReach(box, gate_m);
  }
  CylinderModel Centred(const Vector3& p) const;

  ConeModel AsCone() const {
    return {.point = point, .axis = axis, .radius_m = radius_m, .slope = 0, .side = side};
  }
};

}  // namespace cwm::perception
