// The models that are searched for. A new one is added here, to the options and to the selection.
#pragma once

#include <variant>

#include "perception/search/cone_model.h"
#include "perception/search/cylinder_model.h"
#include "perception/search/plane_model.h"
#include "perception/search/sphere_model.h"

namespace cwm::perception {

static_assert(ShapeModel<PlaneModel> && ShapeModel<SphereModel> && ShapeModel<CylinderModel> &&
              ShapeModel<ConeModel>);

// In order of their degrees of freedom: 3, 4, 5, 6.
using AnyModel = std::variant<PlaneModel, SphereModel, CylinderModel, ConeModel>;

inline bool IsPlane(const AnyModel& model) { return std::holds_alternative<PlaneModel>(model); }

inline double Distance_m(const AnyModel& model, const Vector3& p) {
  return std::visit([&p](const auto& m) { return m.Distance_m(p); }, model);
}

inline int ParameterCount(const AnyModel& model) {
  return std::visit([](const auto& m) { return m.kParameterCount; }, model);
}

}  // namespace cwm::perception
