// A cone's lateral surface, given by the radius at a mid plane and the slope along the axis, so
// that slope 0 is the cylinder and cups are well conditioned (their apex is far away).
#pragma once

#include <algorithm>
#include <cmath>

#include "perception/search/shape_model.h"

namespace cwm::perception {

// A position relative to an axis: the height along it, and the direction and distance away from it.
struct AxialPosition {
  double height_m = 0;
  double radius_m = 0;
  Vector3 outward = Vector3::UnitX();  // any direction away from the axis on it
};

struct ConeModel {
  using Sample = std::array<SamplePoint, 3>;
  // Shift of the axis along two basis vectors, its tilt about them, growth of the radius, and of
  // the slope (metres, metres, radians, radians, metres, 1).
  enum : int { kFirstShift, kSecondShift, kFirstTilt, kSecondTilt, kGrowth, kSlope };
  using Parameters = Eigen::Matrix<double, 6, 1>;
  static constexpr int kParameterCount = Parameters::RowsAtCompileTime;

  Vector3 point = Vector3::Zero();  // on the axis, in the mid plane
  Vector3 axis = Vector3::UnitZ();  // unit
  double radius_m = 0;              // in the mid plane
  double slope = 0;  // growth of the radius per metre along the axis: tan(half angle)
  SeenFrom side = SeenFrom::kOutside;

  // The normals of a cone make one angle with the axis, so their differences are normal to it.
  static std::optional<ConeModel> FromSample(std::span<const SamplePoint> sample);
  // The cone around a known axis direction, from two points or more.
  static std::optional<ConeModel> AroundAxis(std::span<const SamplePoint> sample,
                                             const Vector3& axis);
  double RadiusAt_m(double height_m) const { return radius_m + slope * height_m; }
  // (rr - r - s h) / sqrt(1 + s^2) with rr the distance from the axis: one nappe, because rr is not
  // negative; beyond the apex it overestimates.
  double Distance_m(const Vector3& p) const {
    const Vector3 x = p - point;
    const double height_m = axis.dot(x);
    const double rr = std::sqrt(std::max(0.0, x.squaredNorm() - height_m * height_m));
    return (rr - radius_m - slope * height_m) / std::sqrt(1 + slope * slope);
  }
  Vector3 Normal(const Vector3& p) const {  // any direction of the cone on the axis
    return (Locate(p).outward - slope * axis) / std::sqrt(1 + slope * slope);
  }
  AxialPosition Locate(const Vector3& p) const {
    const Vector3 x = p - point;
    const double height_m = axis.dot(x);
    const Vector3 away = x - height_m * axis;
    const double away_m = away.norm();
    return {height_m, away_m,
            away_m > 0 ? Vector3((1 / away_m) * away) : Vector3(BasisFromZ(axis).col(0))};
  }
  double FacingSign() const { return SignOf(side); }
  Parameters Gradient(const Vector3& p) const;
  ConeModel Moved(const Parameters& step) const;
  bool MayReach(const CellBounds& box, double gate_m) const;
  ConeModel Centred(const Vector3& p) const;
  // As CylinderModel::AsCone, for code that serves both.
  const ConeModel& AsCone() const { return *this; }
};

// The point in which the lines p - t n of a sample meet in the plane normal to `axis`, by least
// squares; empty if they are parallel. The sign of the mean t determines the side.
struct AxisFoot {
  Vector3 point = Vector3::Zero();
  double radius_m = 0;  // mean distance of the sample from the axis
  SeenFrom side = SeenFrom::kOutside;
};
std::optional<AxisFoot> FindAxisFoot(std::span<const SamplePoint> sample, const Vector3& axis);

}  // namespace cwm::perception
