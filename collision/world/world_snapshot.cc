#include "collision/world/world_snapshot.h"

#include <algorithm>
#include <cassert>

namespace cwm::collision {
namespace {

BoundsTree<WorldObject> TreeOver(std::span<const WorldObjectPtr> objects) {
  std::vector<const WorldObject*> items;
  items.reserve(objects.size());
  for (const WorldObjectPtr& object : objects) items.push_back(object.get());
  return BoundsTree<WorldObject>(items);
}

}  // namespace

WorldSnapshot::WorldSnapshot(Revision revision, std::span<const WorldObjectPtr> objects_by_name)
    : revision_(revision), objects_(objects_by_name), bounds_(TreeOver(objects_by_name)) {
  assert(std::is_sorted(objects_by_name.begin(), objects_by_name.end(),
                        [](const auto& a, const auto& b) { return a->name < b->name; }));
}

WorldSnapshot WorldSnapshot::After(Revision revision, std::span<const ObjectDelta> deltas) const {
  WorldSnapshot next = *this;
  next.revision_ = revision;
  for (const auto& [before, after] : deltas) {
    if (before != nullptr) next.bounds_ = next.bounds_.Without(*before);
    if (after != nullptr) {
      next.bounds_ = next.bounds_.With(*after);
      next.objects_ = next.objects_.With(after);
    } else {
      next.objects_ = next.objects_.Without(before->name);
    }
  }
  return next;
}

WorldObjectPtr WorldSnapshot::Find(std::string_view name) const {
  const WorldObjectPtr* object = objects_.Find(name);
  return object != nullptr ? *object : nullptr;
}

std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after) {
  return ObjectTable::Difference(before.objects(), after.objects());
}

}  // namespace cwm::collision
