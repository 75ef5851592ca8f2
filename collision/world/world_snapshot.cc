#include "collision/world/world_snapshot.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cwm::collision {
namespace {

BoundsTree TreeOver(const std::vector<WorldObjectPtr>& objects) {
  std::vector<Aabb> boxes;
  boxes.reserve(objects.size());
  for (const WorldObjectPtr& object : objects) boxes.push_back(object->bounds_W);
  return BoundsTree(boxes);
}

}  // namespace

WorldSnapshot::WorldSnapshot(Revision revision, std::vector<WorldObjectPtr> objects_by_name)
    : revision_(revision), objects_(std::move(objects_by_name)), bounds_(TreeOver(objects_)) {
  assert(std::is_sorted(objects_.begin(), objects_.end(),
                        [](const auto& a, const auto& b) { return a->name < b->name; }));
}

WorldObjectPtr WorldSnapshot::Find(std::string_view name) const {
  const auto at = std::lower_bound(
      objects_.begin(), objects_.end(), name,
      [](const WorldObjectPtr& object, std::string_view n) { return object->name < n; });
  return at != objects_.end() && (*at)->name == name ? *at : nullptr;
}

std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after) {
  std::vector<ObjectDelta> deltas;
  auto b = before.objects().begin();
  auto a = after.objects().begin();
  while (b != before.objects().end() || a != after.objects().end()) {
    const bool only_before =
        a == after.objects().end() || (b != before.objects().end() && (*b)->name < (*a)->name);
    const bool only_after =
        !only_before && (b == before.objects().end() || (*a)->name < (*b)->name);
    if (only_before) {
      deltas.push_back({.before = *b++, .after = nullptr});
    } else if (only_after) {
      deltas.push_back({.before = nullptr, .after = *a++});
    } else {
      if ((*b)->uid != (*a)->uid) {
        deltas.push_back({.before = *b, .after = nullptr});
        deltas.push_back({.before = nullptr, .after = *a});
      } else if (*b != *a) {
        deltas.push_back({.before = *b, .after = *a});
      }
      ++b;
      ++a;
    }
  }
  return deltas;
}

}  // namespace cwm::collision
