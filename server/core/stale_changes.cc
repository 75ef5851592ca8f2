#include "server/core/stale_changes.h"

#include <algorithm>
#include <variant>

#include "perception/cloud/sensor_noise.h"

namespace cwm::server {

ChangesSince::ChangesSince(const collision::WorldSnapshot& matched,
                           const collision::WorldSnapshot& latest)
    : matched_(matched) {
  for (const collision::ObjectDelta& delta : Difference(matched, latest)) {
    for (const collision::WorldObjectPtr& object : {delta.before, delta.after}) {
      // Movers come and go in front of things, and are none of them.
      if (object == nullptr || object->kind == collision::ObjectKind::kMover) continue;
      names_.insert(object->name);
      places_W_.push_back(object->bounds_W);
    }
  }
  for (const collision::RobotDelta& delta : RobotDifference(matched, latest)) {
    // A robot takes names; its place is no object's.
    if (delta.before == nullptr) names_.insert(delta.after->name);
  }
}

bool ChangesSince::Concern(const collision::Change& change) const {
  if (names_.contains(NameOf(change))) return true;
  const auto* put = std::get_if<collision::PutObject>(&change.what);
  if (put == nullptr || matched_.Find(put->name) != nullptr) return false;
  const Aabb bounds_W = TightBounds(*put->geometry->model, put->X_WO);
  return std::ranges::any_of(places_W_, [&](const Aabb& place_W) {
    return place_W.exteriorDistance(bounds_W) <= perception::kExplainedWithin_m;
  });
}

std::vector<std::string> ChangesSince::DropFrom(std::vector<collision::Change>& changes) const {
  std::vector<std::string> dropped;
  std::erase_if(changes, [&](const collision::Change& change) {
    if (!Concern(change)) return false;
    dropped.push_back(NameOf(change));
    return true;
  });
  return dropped;
}

}  // namespace cwm::server
