#include "perception/search/cone_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cwm::perception {

std::optional<AxisFoot> FindAxisFoot(std::span<const SamplePoint> sample, const Vector3& axis) {
  const Matrix3 basis = BasisFromZ(axis);
  const double share = 1 / static_cast<double>(sample.size());
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  Vector2 b = Vector2::Zero();
  for (const auto& [p, n] : sample) {
    Vector2 d(basis.col(0).dot(n), basis.col(1).dot(n));
    const double norm = d.norm();
    if (norm < 0.1) continue;  // the normal runs along the axis and does not lead to it
    d /= norm;
    const Eigen::Matrix2d projector = Eigen::Matrix2d::Identity() - d * d.transpose();
    a += share * projector;
    b += share * projector * Vector2(basis.col(0).dot(p), basis.col(1).dot(p));
  }
  if (a.determinant() < kParallel_determinant) return std::nullopt;
  const Vector2 foot = a.inverse() * b;
  AxisFoot result;
  result.point = foot.x() * basis.col(0) + foot.y() * basis.col(1);
  int outside = 0;
  for (const auto& [p, n] : sample) {
    const Vector3 x = p - result.point;
    const Vector3 away = x - axis.dot(x) * axis;
    result.radius_m += share * away.norm();
    outside += away.dot(n) > 0 ? 1 : -1;
  }
  // Nine of ten normals, or all of a few, must be on one side.
  if (std::abs(outside) < 0.8 * static_cast<double>(sample.size())) return std::nullopt;
  result.side = outside > 0 ? SeenFrom::kOutside : SeenFrom::kInside;
  return result;
}

std::optional<ConeModel> ConeModel::FromSample(std::span<const SamplePoint> sample) {
  const Vector3 normal = (sample[1].n - sample[0].n).cross(sample[2].n - sample[0].n);
  const double norm = normal.norm();
  if (norm < 0.01) return std::nullopt;  // differences of 6 degrees are noise alone
  return AroundAxis(sample, normal / norm);
}

std::optional<ConeModel> ConeModel::AroundAxis(std::span<const SamplePoint> sample,
                                               const Vector3& axis) {
  const std::optional<AxisFoot> foot = FindAxisFoot(sample, axis);
  if (!foot) return std::nullopt;
  double along = 0, across = 0, height_m = 0;
  for (const SamplePoint& s : sample) {
    const double a = SignOf(foot->side) * axis.dot(s.n);
    along += a;
    across += std::sqrt(std::max(0.0, 1 - a * a));
    height_m += axis.dot(s.p - foot->point) / static_cast<double>(sample.size());
  }
  if (across < 1e-6) return std::nullopt;
  ConeModel cone;
  cone.axis = axis;
  cone.side = foot->side;
  cone.slope = -along / across;  // the outward normal is (outward - slope axis) / sqrt(1 + slope^2)
  cone.point = foot->point + height_m * axis;
  cone.radius_m = foot->radius_m;
  return cone;
}

ConeModel::Parameters ConeModel::Gradient(const Vector3& p) const {
  const AxialPosition at = Locate(p);
  const Matrix3 basis = BasisFromZ(axis);
  const double over_k = 1 / std::sqrt(1 + slope * slope);
  const double distance_m = (at.radius_m - radius_m - slope * at.height_m) * over_k;
  const double across_x = over_k * at.outward.dot(basis.col(0));
  const double across_y = over_k * at.outward.dot(basis.col(1));
  const double lever_m = at.height_m + slope * at.radius_m;
  Parameters gradient;
  gradient << -across_x, -across_y, -lever_m * across_x, -lever_m * across_y, -over_k,
      -over_k * (at.height_m + distance_m * slope * over_k);
  return gradient;
}

ConeModel ConeModel::Moved(const Parameters& step) const {
  const Matrix3 basis = BasisFromZ(axis);
  ConeModel moved = *this;
  moved.point += step(kFirstShift) * basis.col(0) + step(kSecondShift) * basis.col(1);
  moved.axis =
      (axis + step(kFirstTilt) * basis.col(0) + step(kSecondTilt) * basis.col(1)).normalized();
  moved.radius_m += step(kGrowth);
  moved.slope += step(kSlope);
  return moved;
}

bool ConeModel::MayReach(const CellBounds& box, double gate_m) const {
  const double gate = gate_m * std::sqrt(1 + slope * slope);
  const AxialPosition at = Locate(box.center);
  const double middle = at.radius_m - RadiusAt_m(at.height_m);
  // rr is at least the coordinate along the centre's outward direction, so rr - s h is at least a
  // linear function, whose minimum over a box is known.
  const double min_distance_m = middle - (at.outward - slope * axis).cwiseAbs().dot(box.half_m);
  if (min_distance_m > gate) return false;
  // rr - s h is convex: largest in a corner.
  double max_distance_m = -std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 sign((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    const Vector3 x = box.center + sign.cwiseProduct(box.half_m) - point;
    const double h = axis.dot(x);
    max_distance_m = std::max(max_distance_m, (x - h * axis).norm() - RadiusAt_m(h));
    if (max_distance_m >= -gate) return true;
  }
  return false;
}

ConeModel ConeModel::Centred(const Vector3& p) const {
  const double height_m = axis.dot(p - point);
  ConeModel centred = *this;
  centred.point += height_m * axis;
  centred.radius_m = RadiusAt_m(height_m);
  return centred;
}

}  // namespace cwm::perception
