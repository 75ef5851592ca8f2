#include <utility>

#include "collision/query/query.h"

namespace cwm::collision {

QueryBody BodyFromShapes(std::vector<Placed<>> shapes, WorkCounter* work) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.reserve(shapes.size());
  for (Placed<>& placed : shapes) {
    model->shapes.push_back({.X_OS = placed.X_FS,
                             .shape = std::move(placed.shape),
                             .role = PartRole::kFitted,
                             .fit = std::nullopt});
  }
  return {.geometry = Prepare(std::move(model), work)};
}

QueryBody BodyFromObject(const WorldObject& object) {
  return {.geometry = object.geometry,
          .self = object.name,
          .margin_m = object.margin_m,
          .supported_by = object.supported_by,
          .attachment = object.attachment,
          .hidden_m = object.geometry->max_hidden_m};
}

}  // namespace cwm::collision
