#include "perception/search/sphere_model.h"

#include <Eigen/LU>
#include <cmath>

namespace cwm::perception {
namespace {

// The side on which nine of ten normals agree, or all of a few; empty if they disagree.
std::optional<SeenFrom> SideOf(std::span<const SamplePoint> sample, const Vector3& center) {
  int outside = 0;
  for (const auto& [p, n] : sample) outside += (p - center).dot(n) > 0 ? 1 : -1;
  if (std::abs(outside) < 0.8 * static_cast<double>(sample.size())) return std::nullopt;
  return outside > 0 ? SeenFrom::kOutside : SeenFrom::kInside;
}

}  // namespace

std::optional<SphereModel> SphereModel::FromSample(std::span<const SamplePoint> sample) {
  Matrix3 a = Matrix3::Zero();
  Vector3 b = Vector3::Zero();
  for (const auto& [p, n] : sample) {
    const Matrix3 projector = Matrix3::Identity() - n * n.transpose();
    a += projector / static_cast<double>(sample.size());
    b += projector * p / static_cast<double>(sample.size());
  }
  if (a.determinant() < kParallel_determinant) return std::nullopt;
  SphereModel sphere;
  sphere.center = a.inverse() * b;
  const std::optional<SeenFrom> side = SideOf(sample, sphere.center);
  if (!side) return std::nullopt;
  sphere.side = *side;
  for (const auto& [p, n] : sample) {
    sphere.radius_m += (p - sphere.center).norm() / static_cast<double>(sample.size());
  }
  return sphere;
}

SphereModel::Parameters SphereModel::Gradient(const Vector3& p) const {
  const Vector3 n = Normal(p);
  return {-n.x(), -n.y(), -n.z(), -1};
}

SphereModel SphereModel::Moved(const Parameters& step) const {
  return {.center = center + step.head<3>(), .radius_m = radius_m + step(3), .side = side};
}

bool SphereModel::MayReach(const CellBounds& box, double gate_m) const {
  // Nearest and farthest point of the box from the centre (Arvo, "Solid box - solid sphere").
  const Vector3 q = (box.center - center).cwiseAbs();
  const double farthest_m = (q + box.half_m).norm();
  const double nearest_m = (q - box.half_m).cwiseMax(0).norm();
  return nearest_m <= radius_m + gate_m && farthest_m >= radius_m - gate_m;
}

}  // namespace cwm::perception
