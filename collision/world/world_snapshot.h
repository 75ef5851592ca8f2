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
#include "collision/world/object_table.h"
#include "collision/world/world_object.h"

namespace cwm::collision {

// What the tree over the bounds knows of an object.
inline const Aabb& BoundsOf(const WorldObject& object) { return object.bounds_W; }
inline bool Precedes(const WorldObject& a, const WorldObject& b) { return a.name < b.name; }
inline std::uint64_t SaltOf(const WorldObject& object) { return HashOf(object.name); }

class WorldSnapshot {
 public:
  // The empty world at revision 0.
  WorldSnapshot() = default;
  // Objects made by Place, ordered by name.
  WorldSnapshot(Revision revision, std::span<const WorldObjectPtr> objects_by_name);

  // The snapshot that differs from this one by the deltas, each of another name: `before` is what
  // this one holds, `after` made by Place. Shares all that the deltas do not touch: a delta costs
  // some dozens of small nodes, whatever the number of objects.
  WorldSnapshot After(Revision revision, std::span<const ObjectDelta> deltas) const;

  Revision revision() const { return revision_; }
  // Ordered by name.
  const ObjectTable& objects() const { return objects_; }
  // nullptr when there is none.
  WorldObjectPtr Find(std::string_view name) const;
  // Over the objects' bounds in the world frame.
  const BoundsTree<WorldObject>& bounds() const { return bounds_; }

 private:
  Revision revision_;
  ObjectTable objects_;
  BoundsTree<WorldObject> bounds_;  // refers to objects that objects_ keeps alive
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

// Which change Apply refused, as a payload of its status; nothing for a status of another source.
struct ApplyFault {
  std::size_t change = 0;  // index in the list
  std::string field;       // "name", "pose", "geometry" or "margin_m"; empty: the change as a whole
  std::string rule;        // what the field breaks, or what is wrong with the change
};
std::optional<ApplyFault> FaultOf(const absl::Status& status);

// What differs between two snapshots of one world, ordered by name. An object that was removed and
// put again is two deltas, removed first.
std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after);

}  // namespace cwm::collision
