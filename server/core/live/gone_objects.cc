#include "server/core/live/gone_objects.h"

#include <algorithm>

namespace cwm::server {

using collision::WorldObject;
using collision::WorldObjectPtr;
using perception::ShapeSignature;

void GoneObjects::Add(const WorldObjectPtr& object, perception::Stamp now) {
  gone_.push_back({object, ShapeSignature(object->model()), now});
}

void GoneObjects::ForgetAfter(std::chrono::nanoseconds time, perception::Stamp now) {
  std::erase_if(gone_, [&](const Gone& each) {
    const bool is_old = now - each.when > time;
    if (is_old) uncertain_.erase(each.object->name);
    return is_old;
  });
}

std::vector<WorldObjectPtr> GoneObjects::objects() const {
  std::vector<WorldObjectPtr> objects;
  for (const Gone& each : gone_) objects.push_back(each.object);
  return objects;
}

std::vector<std::string> GoneObjects::SeenAgain(const WorldObject& object,
                                                std::span<const WorldObjectPtr> lost) {
  std::erase_if(gone_, [&](const Gone& each) { return each.object->name == object.name; });
  const ShapeSignature signature(object.model());
  std::vector<std::string> twins;
  for (const Gone& each : gone_) {
    if (signature.IsAlike(each.signature)) twins.push_back(each.object->name);
  }
  for (const WorldObjectPtr& each : lost) {
    if (each->name != object.name && signature.IsAlike(ShapeSignature(each->model()))) {
      twins.push_back(each->name);
    }
  }
  if (twins.empty()) return {};
  twins.push_back(object.name);
  uncertain_.insert(twins.begin(), twins.end());
  return twins;
}

}  // namespace cwm::server
