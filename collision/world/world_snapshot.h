// The world at one revision: immutable, shared by as many readers as like, answering for ever as it
// did.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/broadphase/bounds_tree.h"
#include "collision/world/world_object.h"

namespace cwm::collision {

using WorldObjectPtr = std::shared_ptr<const WorldObject>;

class WorldSnapshot {
 public:
  // The empty world at revision 0.
  WorldSnapshot() = default;
  // Objects made by Place, ordered by name.
  WorldSnapshot(Revision revision, std::vector<WorldObjectPtr> objects_by_name);

  Revision revision() const { return revision_; }
  // Ordered by name.
  const std::vector<WorldObjectPtr>& objects() const { return objects_; }
  // nullptr when there is none.
  WorldObjectPtr Find(std::string_view name) const;
  // Over the objects' bounds in the world frame; leaf i is objects()[i].
  const BoundsTree& bounds() const { return bounds_; }

 private:
  Revision revision_;
  std::vector<WorldObjectPtr> objects_;
  BoundsTree bounds_;
};

// Adds or replaces the object of that name. A put over an object that is equal in all fields has no
// effect; an equal model keeps the geometry revision even when it was prepared again.
struct PutObject {
  std::string name;
  ObjectKind kind = ObjectKind::kUser;
  Owner owner = Owner::kUser;
  ObjectState state = ObjectState::kConfirmed;
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const PreparedModel> geometry;
  std::string supported_by;
  double margin_m = 0;
};
struct MoveObject {
  std::string name;
  Pose X_WO = Pose::Identity();
};
struct RemoveObject {
  std::string name;
};

struct Change {
  std::variant<PutObject, MoveObject, RemoveObject> what;
  // WorldObject::latest_revision() before this list, as its writer knew it; another one, or no such
  // object, aborts the whole list.
  std::optional<Revision> expected_object_revision;
};

// Applies all changes in order or none. Returns the new snapshot at base.revision() + 1; the base
// itself when nothing has an effect. NotFound names a missing object, Aborted a revision that does
// not match, InvalidArgument a name, pose, margin or geometry that no world may hold; all name the
// index of the change. Cost: the changes, and one pointer and one box per object; geometry is
// shared, never touched.
absl::StatusOr<std::shared_ptr<const WorldSnapshot>> Apply(
    const std::shared_ptr<const WorldSnapshot>& base, std::span<const Change> changes);

// What differs between two snapshots of one world: for watches and for tests.
struct ObjectDelta {
  WorldObjectPtr before;  // nullptr: added
  WorldObjectPtr after;   // nullptr: removed
};
// Ordered by name. An object that was removed and put again is two deltas, removed first.
std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after);

}  // namespace cwm::collision
