#include "perception/search/plane_model.h"

#include <cmath>

namespace cwm::perception {

std::optional<PlaneModel> PlaneModel::FromSample(std::span<const SamplePoint> sample) {
  return PlaneModel{.point = sample[0].p, .normal = sample[0].n};
}

PlaneModel::Parameters PlaneModel::Gradient(const Vector3& p) const {
  const Matrix3 basis = BasisFromZ(normal);
  return {basis.col(0).dot(p - point), basis.col(1).dot(p - point), -1};
}

PlaneModel PlaneModel::Moved(const Parameters& step) const {
  const Matrix3 basis = BasisFromZ(normal);
  return {.point = point + step(kShift) * normal,
          .normal = (normal + step(kFirstTilt) * basis.col(0) + step(kSecondTilt) * basis.col(1))
                        .normalized()};
}

bool PlaneModel::MayReach(const CellBounds& box, double gate_m) const {
  // The box's dimension towards the plane (paper, section V).
  return std::abs(Distance_m(box.center)) <= gate_m + normal.cwiseAbs().dot(box.half_m);
}

PlaneModel PlaneModel::Centred(const Vector3& p) const {
  return {.point = p - Distance_m(p) * normal, .normal = normal};
}

}  // namespace cwm::perception
