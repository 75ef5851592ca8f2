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
#include "collision/world/pair_rules.h"
#include "collision/world/robot_state.h"
#include "collision/world/world_object.h"
#include "collision/world/world_robot.h"

namespace cwm::collision {

// What the tree over the bounds knows of an obstacle.
inline const Aabb& BoundsOf(const Obstacle& obstacle) { return obstacle.bounds_W; }
inline bool Precedes(const Obstacle& a, const Obstacle& b) { return a.name < b.name; }
inline std::uint64_t SaltOf(const Obstacle& obstacle) { return HashOf(obstacle.name); }

class WorldSnapshot {
 public:
  // The empty world at revision 0.
  WorldSnapshot() = default;
  // Objects made by Place, ordered by name; robots likewise.
  WorldSnapshot(Revision revision, std::span<const WorldObjectPtr> objects_by_name,
                std::vector<WorldRobotPtr> robots_by_name = {}, PairRules pair_rules = {});

  // The snapshot that differs from this one by the deltas, each of another name: `before` is what
  // this one holds, `after` made by Place. Shares all that the deltas do not touch: a delta costs
  // some dozens of small nodes, whatever the number of objects; deltas of robots besides a pointer
  // for each robot, of which there are few. `pair_rules`: all; nullptr where none differs. Void where
  // `work` ended it.
  WorldSnapshot After(Revision revision, std::span<const ObjectDelta> deltas,
                      std::span<const RobotDelta> robot_deltas = {},
                      std::shared_ptr<const PairRules> pair_rules = nullptr,
                      WorkCounter* work = nullptr) const;

  Revision revision() const { return revision_; }
  // Ordered by name.
  const ObjectTable& objects() const { return objects_; }
  // Of all parts of objects and robots (WeightOfAsking).
  std::int64_t weight() const { return weight_; }
  // nullptr when there is none.
  WorldObjectPtr Find(std::string_view name) const;
  // Over the bounds of all objects and robots in the world frame.
  const BoundsTree<Obstacle>& bounds() const { return bounds_; }
  // Objects that are attached, ordered by name. Few; shared by all snapshots between which none
  // differs.
  const std::vector<WorldObjectPtr>& attached() const { return *attached_; }
  // Objects by rank, then robots: how answers number what they name.
  const Obstacle& ObstacleAt(std::size_t index) const;
  // Of one that this snapshot holds.
  std::size_t IndexOf(const Obstacle& obstacle) const;
  // Its place among all objects and robots, ordered by name.
  std::size_t RankByName(const Obstacle& obstacle) const;

  // Ordered by name; no robot has the name of an object. Shared by all snapshots between which no
  // robot differs.
  const std::vector<WorldRobotPtr>& robots() const { return *robots_; }
  // nullptr when there is none.
  WorldRobotPtr FindRobot(std::string_view name) const;

  // Shared by all snapshots between which none differs. They may be of things that are not there.
  const PairRules& pair_rules() const { return *pair_rules_; }

 private:
  using Robots = std::vector<WorldRobotPtr>;

  Revision revision_;
  std::int64_t weight_ = 0;
  ObjectTable objects_;
  BoundsTree<Obstacle> bounds_;  // refers to what objects_ and robots_ keep alive
  std::shared_ptr<const std::vector<WorldObjectPtr>> attached_ =
      std::make_shared<const std::vector<WorldObjectPtr>>();
  std::shared_ptr<const Robots> robots_ = std::make_shared<const Robots>();
  std::shared_ptr<const PairRules> pair_rules_ = std::make_shared<const PairRules>();
};

// Adds or replaces the object of that name. A put over an object that is equal in all fields has no
// effect; an equal model keeps the geometry revision even when it was prepared again. It says where
// the object stands: one that was attached stands free then, and so does one that is moved.
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

// Fixes the object to a link of the robot as it stands by then; one that is attached already is
// attached anew. It moves with the link until it is put, moved or detached, or the link is no more:
// then it stands where it is.
struct AttachObject {
  std::string name;
  std::string robot;
  std::string link;
  std::optional<Pose> X_LO = {};              // absent: where it is
  std::vector<std::string> touch_links = {};  // in any order
};
// Of one that is not attached: no effect.
struct DetachObject {
  std::string name;
};

// Adds the robot. One of that name whose robot is equal (SameRobot) only gets base and state;
// another one is replaced, and what then has the name is a new robot.
struct PutRobot {
  std::string name;
  std::shared_ptr<const RobotGeometry> robot;
  Pose X_WB = Pose::Identity();
  std::vector<double> state;  // one value for each variable
};
struct RemoveRobot {
  std::string name;
};
// Sets what is given, and leaves the rest as it is.
struct SetRobotState {
  std::string name;
  std::optional<Pose> X_WB;
  JointValues joints;
};

// Lets the pair collide: no question sees it. Allowed once more it gets the new time of expiry, or
// none. What is named may not be there, yet or any more: a rule outlives what it is about.
struct AllowCollision {
  NamedPair pair;                      // in either order
  bool withdraw = false;               // ends what was allowed of the very pair
  std::optional<Expiry> expires = {};  // when the server publishes its end; absent: never
};
struct SetPairMargin {
  NamedPair pair;
  std::optional<double> margin_m;  // >= 0; absent: ends what was set of the very pair
};
// Ends what is allowed until `now` or before.
struct ExpireRules {
  SteadyTime now;
};

// Rules of pairs in one world: more are refused. Some hundreds are expected; a change of one copies
// them all, in about a millisecond then.
inline constexpr std::size_t kMostPairRules = 4096;

struct Change {
  std::variant<PutObject, MoveObject, RemoveObject, AttachObject, DetachObject, PutRobot,
               RemoveRobot, SetRobotState, AllowCollision, SetPairMargin, ExpireRules>
      what;
  // latest_revision() of the object or robot before this list, as its writer knew it; another one,
  // or no such object, aborts the whole list. Not for rules of pairs, which have none.
  std::optional<Revision> expected_object_revision;
};

// Of the object or robot that the change is about; empty for rules of pairs.
const std::string& NameOf(const Change& change);
bool IsOfRobot(const Change& change);
bool IsOfPairs(const Change& change);
// What `expected_object_revision` is compared with; nothing when there is no such object or robot.
std::optional<Revision> LatestRevisionOf(const WorldSnapshot& snapshot, const Change& change);

// Applies all changes in order or none. Returns the new snapshot at base.revision() + 1; the base
// itself when nothing has an effect. NotFound names a missing object or robot, Aborted a revision
// that does not match, InvalidArgument a name, pose, margin, geometry or state that no world may
// hold, or the name of a robot for an object or the other way round, ResourceExhausted more than
// kMostPairRules; all name the index of the change. Cancelled, with none, where `work` ended it. Cost:
// the changes, each with the paths to it; geometry is shared, never touched.
absl::StatusOr<std::shared_ptr<const WorldSnapshot>> Apply(
    const std::shared_ptr<const WorldSnapshot>& base, std::span<const Change> changes,
    WorkCounter* work = nullptr);

// Which change Apply refused, as a payload of its status; nothing for a status of another source.
struct ApplyFault {
  std::size_t change = 0;  // index in the list
  // "name", "pose", "geometry", "margin_m"; of what is attached "robot", "link", "x_link_object",
  // "touch_links[2]"; of a robot "name", "x_world_base", "robot", "state",
  // "joints.values[2].variable" and the like; of a pair "pair.a.name", "margin_m" and the like;
  // "expected_object_revision"; empty: the change as a whole.
  std::string field;
  std::string rule;  // what the field breaks, or what is wrong with the change
};
std::optional<ApplyFault> FaultOf(const absl::Status& status);
// Whether what Apply has not found is a robot.
bool IsOfUnknownRobot(const Change& change, const ApplyFault& fault);

// What differs between two snapshots of one world, ordered by name. An object that was removed and
// put again is two deltas, removed first.
std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after);
// Of the robots, likewise.
std::vector<RobotDelta> RobotDifference(const WorldSnapshot& before, const WorldSnapshot& after);

}  // namespace cwm::collision
