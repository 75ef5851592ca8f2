// The world at one revision. Immutable, and shared by any number of readers, to which it always
// gives the same answers.
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

// The functions that BoundsTree needs for its items.
inline const Aabb& BoundsOf(const Obstacle& obstacle) { return obstacle.bounds_W; }
inline bool Precedes(const Obstacle& a, const Obstacle& b) { return a.name < b.name; }
inline std::uint64_t SaltOf(const Obstacle& obstacle) { return HashOf(obstacle.name); }

class WorldSnapshot {
 public:
  // The empty world at revision 0.
  WorldSnapshot() = default;
  // Objects and robots are made by Place and ordered by name.
  WorldSnapshot(Revision revision, std::span<const WorldObjectPtr> objects_by_name,
                std::vector<WorldRobotPtr> robots_by_name = {}, PairRules pair_rules = {});

  // The snapshot that differs from this one by the deltas. Each delta has another name; its
  // `before` is in this snapshot, its `after` is made by Place. The new snapshot shares everything
  // that the deltas do not touch: a delta costs some dozens of small nodes, however many objects
  // there are, and deltas of robots also a pointer for each robot, of which there are few.
  // `pair_rules` has all rules, or is nullptr if none changed. Void if `work` stopped the function.
  WorldSnapshot After(Revision revision, std::span<const ObjectDelta> deltas,
                      std::span<const RobotDelta> robot_deltas = {},
                      std::shared_ptr<const PairRules> pair_rules = nullptr,
                      WorkCounter* work = nullptr) const;

  Revision revision() const { return revision_; }
  // Ordered by name.
  const ObjectTable& objects() const { return objects_; }
  // The sum of QueryCost over all parts of objects and robots.
  std::int64_t weight() const { return weight_; }
  // nullptr if there is none.
  WorldObjectPtr Find(std::string_view name) const;
  // A tree over the bounds of all objects and robots in the world frame.
  const BoundsTree<Obstacle>& bounds() const { return bounds_; }
  // Attached objects, ordered by name. There are few; shared by all snapshots with the same ones.
  const std::vector<WorldObjectPtr>& attached() const { return *attached_; }
  // Objects that may extend into space that no sensor saw (ShapePart::hidden), ordered by name.
  const std::vector<WorldObjectPtr>& with_hidden() const { return *with_hidden_; }
  // True if holes of a mesh of some object or robot were closed (PreparedModel::has_caps).
  bool has_caps() const;
  // An upper bound of the margins of all parts of objects and robots (MarginOf_m).
  double max_margin_m() const;
  // The obstacle with this index in answers: objects by rank, then robots.
  const Obstacle& ObstacleAt(std::size_t index) const;
  // The index of an obstacle of this snapshot.
  std::size_t IndexOf(const Obstacle& obstacle) const;
  // The rank of an obstacle among all objects and robots, ordered by name.
  std::size_t RankByName(const Obstacle& obstacle) const;

  // Ordered by name; no robot has the name of an object. Shared by all snapshots with the same
  // robots.
  const std::vector<WorldRobotPtr>& robots() const { return *robots_; }
  // nullptr if there is none.
  WorldRobotPtr FindRobot(std::string_view name) const;

  // Shared by all snapshots with the same rules. Rules may name items that do not exist.
  const PairRules& pair_rules() const { return *pair_rules_; }

 private:
  using Robots = std::vector<WorldRobotPtr>;

  Revision revision_;
  std::int64_t weight_ = 0;
  ObjectTable objects_;
  BoundsTree<Obstacle> bounds_;  // refers to items that objects_ and robots_ keep alive
  std::shared_ptr<const std::vector<WorldObjectPtr>> attached_ =
      std::make_shared<const std::vector<WorldObjectPtr>>();
  std::shared_ptr<const std::vector<WorldObjectPtr>> with_hidden_ =
      std::make_shared<const std::vector<WorldObjectPtr>>();
  std::shared_ptr<const std::vector<WorldObjectPtr>> with_caps_ =
      std::make_shared<const std::vector<WorldObjectPtr>>();
  std::shared_ptr<const Robots> robots_ = std::make_shared<const Robots>();
  std::shared_ptr<const PairRules> pair_rules_ = std::make_shared<const PairRules>();
};

// Adds or replaces the object of that name. Putting an object with equal fields has no effect; an
// equal model keeps the geometry revision even if it was prepared again. The pose is the given one,
// so a put detaches an attached object, and so does a move.
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

// Attaches the object to a link of the robot in its state at that time, or attaches it anew. The
// object moves with the link until it is put, moved or detached, or the link no longer exists; then
// it stays at its pose.
struct AttachObject {
  std::string name;
  std::string robot;
  std::string link;
  std::optional<Pose> X_LO = {};              // absent: keeps its place
  std::vector<std::string> touch_links = {};  // in any order
};
// No effect if the object is not attached.
struct DetachObject {
  std::string name;
};

// Adds the robot. If the robot of that name is equal (SameRobot), only its base and state are set;
// otherwise it is replaced by a new robot.
struct PutRobot {
  std::string name;
  std::shared_ptr<const RobotGeometry> robot;
  Pose X_WB = Pose::Identity();
  std::vector<double> state;  // one value for each variable
};
struct RemoveRobot {
  std::string name;
};
// Sets the given members and keeps the others.
struct SetRobotState {
  std::string name;
  std::optional<Pose> X_WB;
  JointValues joints;
};

// Lets the pair collide: queries ignore it. Allowing it again sets the new expiry, or none. The
// items need not exist: a rule stays when they are removed.
struct AllowCollision {
  NamedPair pair;                      // in either order
  bool withdraw = false;               // ends the allowance or the check of exactly this pair
  std::optional<Expiry> expires = {};  // absent: never
  // Ends an allowance of exactly this pair. Two links of one robot are from then on checked against
  // each other even if the SRDF disables the pair, or if they are fixed to each other.
  bool check = false;
};
struct SetPairMargin {
  NamedPair pair;
  std::optional<double> margin_m;  // >= 0; absent: removes the margin of exactly this pair
};
// Ends allowances that are due at `now` or before.
struct ExpireRules {
  SteadyTime now;
};

// chosen: the most pair rules in one world. Some hundreds are expected; changing one copies all of
// them, which takes about a millisecond at the limit.
inline constexpr std::size_t kMaxPairRules = 4096;

struct Change {
  std::variant<PutObject, MoveObject, RemoveObject, AttachObject, DetachObject, PutRobot,
               RemoveRobot, SetRobotState, AllowCollision, SetPairMargin, ExpireRules>
      what;
  // latest_revision() of the object or robot before this list, as its writer knows it. If it
  // differs, or there is no such object, the whole list is aborted. Not for rules of pairs, which
  // have no revision.
  std::optional<Revision> expected_object_revision;
};

// The name of the object or robot of the change; empty for rules of pairs.
const std::string& NameOf(const Change& change);
bool IsRobotChange(const Change& change);
bool IsPairRuleChange(const Change& change);
// The revision that is compared with `expected_object_revision`; empty if the object or robot does
// not exist.
std::optional<Revision> LatestRevisionOf(const WorldSnapshot& snapshot, const Change& change);

// Applies all changes in order, or none. Returns the new snapshot at base.revision() + 1, or the
// base itself if nothing has an effect. Errors name the index of the change: NotFound for a missing
// object or robot; Aborted for a revision that does not match; InvalidArgument for a name, pose,
// margin, geometry or state that is not valid, or if an object has the name of a robot or the other
// way round; ResourceExhausted for more than kMaxPairRules. Cancelled, without any change, if
// `work` stopped it. The cost is that of the changes and the paths to them; geometry is shared.
absl::StatusOr<std::shared_ptr<const WorldSnapshot>> Apply(
    const std::shared_ptr<const WorldSnapshot>& base, std::span<const Change> changes,
    WorkCounter* work = nullptr);

// The change that Apply refused, as a payload of its status. FaultOf is empty for other statuses.
struct ApplyFault {
  std::size_t change = 0;  // index in the list
  // "name", "pose", "geometry", "margin_m"; for attachments "robot", "link", "x_link_object",
  // "touch_links[2]"; for robots "name", "x_world_base", "robot", "state",
  // "joints.values[2].variable" and the like; for pairs "pair.a.name", "margin_m" and the like;
  // "expected_object_revision"; empty for the change as a whole.
  std::string field;
  std::string rule;  // the rule that the field or the change violates
};
std::optional<ApplyFault> FaultOf(const absl::Status& status);
// True if the item that Apply did not find is a robot.
bool IsUnknownRobotFault(const Change& change, const ApplyFault& fault);

// The differences between two snapshots of one world, ordered by name. An object that was removed
// and put again gives two deltas, the removal first.
std::vector<ObjectDelta> Difference(const WorldSnapshot& before, const WorldSnapshot& after);
// The same for robots.
std::vector<RobotDelta> RobotDifference(const WorldSnapshot& before, const WorldSnapshot& after);

}  // namespace cwm::collision
