// Objects and changes for tests of the application.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collision/world/world_snapshot.h"

namespace cwm::server {

inline std::shared_ptr<const HybridModel> BoxModel(double edge_m) {
  HybridModel model;
  model.shapes.push_back(
      {.X_OS = Pose::Identity(), .shape = Box{Vector3::Constant(edge_m)}, .fit = {}});
  return std::make_shared<const HybridModel>(std::move(model));
}

inline std::shared_ptr<const collision::PreparedModel> PreparedBox(double edge_m = 0.1) {
  return collision::Prepare(BoxModel(edge_m));
}

// A model shared by all objects in tests that do not depend on geometry.
inline const std::shared_ptr<const collision::PreparedModel>& SharedBox() {
  static const auto& box = *new std::shared_ptr<const collision::PreparedModel>(PreparedBox());
  return box;
}

inline collision::Change Put(std::string name, double x_m = 0) {
  return {collision::PutObject{.name = std::move(name),
                               .X_WO = MakeTranslation(x_m, 0, 0),
                               .geometry = SharedBox(),
                               .supported_by = {}},
          std::nullopt};
}

inline collision::Change Move(std::string name, double x_m) {
  return {collision::MoveObject{std::move(name), MakeTranslation(x_m, 0, 0)}, std::nullopt};
}

inline collision::Change Remove(std::string name) {
  return {collision::RemoveObject{std::move(name)}, std::nullopt};
}

inline std::vector<std::string> NamesIn(const collision::WorldSnapshot& snapshot) {
  std::vector<std::string> names;
  for (const collision::WorldObjectPtr& object : snapshot.objects()) names.push_back(object->name);
  return names;
}

}  // namespace cwm::server
