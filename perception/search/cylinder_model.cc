#include "perception/search/cylinder_model.h"

namespace cwm::perception {

std::optional<CylinderModel> CylinderModel::FromSample(std::span<const SamplePoint> sample) {
  const Vector3 normal = sample[0].n.cross(sample[1].n);
  const double norm = normal.norm();
  if (norm < kParallel_sin) return std::nullopt;
  return AroundAxis(sample, normal / norm);
}

std::optional<CylinderModel> CylinderModel::AroundAxis(std::span<const SamplePoint> sample,
                                                       const Vector3& axis) {
  const std::optional<AxisFoot> foot = FindAxisFoot(sample, axis);
  if (!foot) return std::nullopt;
  const CylinderModel cylinder{
      .point = foot->point, .axis = axis, .radius_m = foot->radius_m, .side = foot->side};
  return cylinder.Centred(sample[0].p);
}

CylinderModel CylinderModel::Moved(const Parameters& step) const {
  ConeModel::Parameters of_cone = ConeModel::Parameters::Zero();
  of_cone.head<kParameterCount>() = step;
  const ConeModel moved = AsCone().Moved(of_cone);
  return {.point = moved.point, .axis = moved.axis, .radius_m = moved.radius_m, .side = side};
}

CylinderModel CylinderModel::Centred(const Vector3& p) const {
  CylinderModel centred = *this;
  centred.point += axis.dot(p - point) * axis;
  return centred;
}

}  // namespace cwm::perception
