// Tells which changes of a scan are out of date, because writers changed the world since the scan
// was matched with it.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "collision/world/world_snapshot.h"

namespace cwm::server {

class ChangesSince {
 public:
  // The objects that differ between the two snapshots of one world.
  ChangesSince(const collision::WorldSnapshot& matched, const collision::WorldSnapshot& latest);

  bool empty() const { return names_.empty(); }
  // True if the change is about one of these objects, or puts a new object where one of them is or
  // was, so that it may be that object.
  bool Concern(const collision::Change& change) const;
  // Erases the changes that they concern, and returns the names of those.
  std::vector<std::string> DropFrom(std::vector<collision::Change>& changes) const;

 private:
  const collision::WorldSnapshot& matched_;
  std::set<std::string> names_;
  std::vector<Aabb> places_W_;  // before and after
};

}  // namespace cwm::server
