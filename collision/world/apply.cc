// Apply: applies a list of changes completely, or not at all.
#include <cmath>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/world/apply_fault.h"
#include "collision/world/attachment.h"
#include "collision/world/model_equality.h"
#include "collision/world/pair_rule_transaction.h"
#include "collision/world/robot_transaction.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {

// A last check; the wire layer already refuses such poses with the name of the field.
bool IsPlaceable(const Pose& X_WO) {
  constexpr double kOrthonormality = 1e-6;  // chosen: far above rounding, far below a visible shear
  const Matrix3 R = X_WO.linear();
  return X_WO.matrix().allFinite() &&
         X_WO.translation().cwiseAbs().maxCoeff() <= kMaxCoordinate_m &&
         (R.transpose() * R - Matrix3::Identity()).cwiseAbs().maxCoeff() <= kOrthonormality &&
         R.determinant() > 0;
}

namespace {

// True if the objects are equal except for their geometry and pose revisions.
bool SameContent(const WorldObject& a, const WorldObject& b) {
  return a.name == b.name && a.create_revision == b.create_revision && a.kind == b.kind &&
         a.owner == b.owner && a.state == b.state && SamePose(a.X_WO, b.X_WO) &&
         a.geometry == b.geometry && a.supported_by == b.supported_by && a.margin_m == b.margin_m &&
         SameAttachment(a.attachment.get(), b.attachment.get());
}

// The error for a name that is taken. Objects and robots share one set of names, because answers
// list both.
absl::Status NameTaken(const std::string& name, std::string_view by) {
  return InvalidFieldError("name", absl::StrCat("'", name, "' is the name of ", std::string(by),
                                                " of this world, must be another one"));
}

// A copy without placed parts. Place adds them at the end, because a list may change one object
// often.
WorldObject Unplaced(const WorldObject& object) {
  WorldObject copy = object;
  copy.parts_W = {};
  return copy;
}

// The work of one change, which takes a microsecond or two: looking up names, copying an object.
constexpr std::size_t kStepsPerChange = 64;

// The objects that a list of changes touches, over an unchanged base. Objects are placed, which is
// costly, only after the whole list has been accepted.
class Transaction {
 public:
  Transaction(const WorldSnapshot& base, WorkCounter* work)
      : base_(base),
        work_(work),
        revision_{base.revision().value + 1},
        robots_(base),
        rules_(base) {}

  absl::Status operator()(const PutObject& put) {
    if (!IsValidName(put.name)) return InvalidNameError(put.name);
    if (robots_.Has(put.name)) return NameTaken(put.name, "a robot");
    if (!IsPlaceable(put.X_WO)) return InvalidPoseError("pose");
    if (put.geometry == nullptr) return InvalidFieldError("geometry", "must be given");
    if (!std::isfinite(put.margin_m) || put.margin_m < 0) {
      return InvalidFieldError(
          "margin_m", absl::StrCat("is ", put.margin_m, ", must be finite and not negative"));
    }
    const WorldObject* current = Current(put.name);
    touched_[put.name] = current != nullptr ? Replaced(*current, put) : Added(put);
    return absl::OkStatus();
  }

  absl::Status operator()(const MoveObject& move) {
    const WorldObject* current = Current(move.name);
    if (current == nullptr) return Missing(move.name);
    if (!IsPlaceable(move.X_WO)) return InvalidPoseError("pose");
    WorldObject moved = Unplaced(*current);
    SetPoseAt(move.X_WO, moved);
    touched_[move.name] = std::move(moved);
    return absl::OkStatus();
  }

  absl::Status operator()(const RemoveObject& remove) {
    if (Current(remove.name) == nullptr) return Missing(remove.name);
    touched_[remove.name] = std::nullopt;
    return absl::OkStatus();
  }

  absl::Status operator()(const AttachObject& attach) {
    const WorldObject* current = Current(attach.name);
    if (current == nullptr) return Missing(attach.name);
    const WorldRobot* robot = robots_.Current(attach.robot);
    if (robot == nullptr) return WithField("robot", RobotNotFoundError(attach.robot));
    absl::StatusOr<Attachment> attachment = AttachmentOf(attach, *robot, *current);
    if (!attachment.ok()) return attachment.status();
    WorldObject attached = Unplaced(*current);
    const bool is_new = !SameAttachment(attached.attachment.get(), &*attachment);
    attached.attachment = std::make_shared<const Attachment>(*std::move(attachment));
    if (is_new) attached.pose_revision = revision_;
    const absl::Status placed = Follow(*robot, attached);
    if (placed.ok()) touched_[attach.name] = std::move(attached);
    return placed;
  }

  absl::Status operator()(const DetachObject& detach) {
    const WorldObject* current = Current(detach.name);
    if (current == nullptr) return Missing(detach.name);
    WorldObject detached = Unplaced(*current);
    SetPoseAt(current->X_WO, detached);
    touched_[detach.name] = std::move(detached);
    return absl::OkStatus();
  }

  absl::Status operator()(const PutRobot& put) {
    if (Current(put.name) != nullptr) return NameTaken(put.name, "an object");
    const absl::Status status = robots_.Put(put);
    return status.ok() ? FollowAll(put.name) : status;
  }
  absl::Status operator()(const RemoveRobot& remove) {
    const absl::Status status = robots_.Remove(remove);
    return status.ok() ? FollowAll(remove.name) : status;
  }
  absl::Status operator()(const SetRobotState& set) {
    const absl::Status status = robots_.Set(set);
    return status.ok() ? FollowAll(set.name) : status;
  }

  // A rule can be withdrawn even if its links no longer exist.
  absl::Status operator()(const AllowCollision& allow) {
    const absl::Status status = allow.withdraw ? absl::OkStatus() : CheckLinksOf(allow.pair);
    return status.ok() ? rules_.Allow(allow) : status;
  }
  absl::Status operator()(const SetPairMargin& set) {
    const bool is_end = !set.margin_m.has_value();
    const absl::Status status = is_end ? absl::OkStatus() : CheckLinksOf(set.pair);
    return status.ok() ? rules_.SetMargin(set) : status;
  }
  absl::Status operator()(const ExpireRules& expire) {
    rules_.Expire(expire);
    return absl::OkStatus();
  }

  absl::Status CheckExpected(const Change& change, Revision expected) const {
    if (IsPairRuleChange(change)) {
      return InvalidFieldError(
          "expected_object_revision",
          "is given, must be absent: rules of pairs have no revision of their own");
    }
    const std::optional<Revision> latest = LatestRevisionOf(base_, change);
    const std::string who =
        absl::StrCat(IsRobotChange(change) ? "robot '" : "object '", NameOf(change), "'");
    if (!latest.has_value()) {
      return absl::AbortedError(
          absl::StrCat(who, " does not exist, expected at revision ", expected.value));
    }
    if (*latest == expected) return absl::OkStatus();
    return absl::AbortedError(
        absl::StrCat(who, " is at revision ", latest->value, ", expected ", expected.value));
  }

  // The next snapshot; nullptr if it would equal the base, or if the work was ended.
  std::shared_ptr<const WorldSnapshot> Finish() {
    std::vector<ObjectDelta> deltas;
    for (auto& [name, object] : touched_) {
      WorldObjectPtr before = base_.Find(name);
      if (MustEnd(work_, kStepsPerChange)) return nullptr;
      if (before == nullptr && !object.has_value()) continue;
      if (before != nullptr && object.has_value() && SameContent(*before, *object)) continue;
      deltas.push_back({.before = std::move(before),
                        .after = object.has_value() ? Place(*std::move(object), work_) : nullptr});
    }
    if (HasEnded(work_)) return nullptr;
    const std::vector<RobotDelta> robot_deltas = robots_.Finish();
    std::shared_ptr<const PairRules> rules = rules_.Finish();
    if (deltas.empty() && robot_deltas.empty() && rules == nullptr) return nullptr;
    return std::make_shared<const WorldSnapshot>(
        base_.After(revision_, deltas, robot_deltas, std::move(rules), work_));
  }

 private:
  static absl::Status Missing(const std::string& name) {
    return absl::NotFoundError(absl::StrCat("object '", name, "' does not exist"));
  }

  // The object after the changes so far; nullptr if there is none. Valid until the next change of
  // that object.
  const WorldObject* Current(const std::string& name) const {
    const auto at = touched_.find(name);
    if (at != touched_.end()) return at->second.has_value() ? &*at->second : nullptr;
    const WorldObjectPtr* object = base_.objects().Find(name);
    return object != nullptr ? object->get() : nullptr;  // kept alive by the base
  }

  absl::Status CheckLinksOf(const NamedPair& pair) const {
    const absl::Status status = CheckLinks(pair, [&](const std::string& name) {
      const WorldRobot* const robot = robots_.Current(name);
      return NameOwner{.robot = robot != nullptr ? &robot->model() : nullptr,
                       .is_object = Current(name) != nullptr};
    });
    const std::optional<FieldRule> fault = FieldRuleOf(status);
    return fault ? InvalidFieldError(absl::StrCat("pair.", fault->field), fault->rule) : status;
  }

  void SetPose(WorldObject& object, const Pose& X_WO) const {
    if (SamePose(object.X_WO, X_WO)) return;
    object.X_WO = X_WO;
    object.pose_revision = revision_;
  }

  // Detaches the object and sets its pose.
  void SetPoseAt(const Pose& X_WO, WorldObject& object) const {
    if (object.attachment != nullptr) object.pose_revision = revision_;
    object.attachment = nullptr;
    SetPose(object, X_WO);
  }

  // Moves an object that is attached to the robot along with its link.
  absl::Status Follow(const WorldRobot& robot, WorldObject& object) const {
    const Attachment& attachment = *object.attachment;
    const std::optional<int> link = robot.model().FindLink(attachment.link);
    if (!link.has_value()) {
      SetPoseAt(object.X_WO, object);
      return absl::OkStatus();
    }
    const Pose X_WO = robot.X_WL[static_cast<std::size_t>(*link)] * attachment.X_LO;
    if (!IsPlaceable(X_WO)) {
      return absl::InvalidArgumentError(
          absl::StrCat("object '", object.name, "', which is attached to link '", attachment.link,
                       "', would come to stand beyond ", kMaxCoordinate_m, " m"));
    }
    SetPose(object, X_WO);
    return absl::OkStatus();
  }

  // Updates all objects attached to the robot, which was moved, replaced or removed.
  absl::Status FollowAll(const std::string& name) {
    const WorldRobot* robot = robots_.Current(name);
    for (const std::string& each : AttachedTo(name)) {
      WorldObject object = Unplaced(*Current(each));
      if (robot == nullptr) {
        SetPoseAt(object.X_WO, object);
      } else if (absl::Status status = Follow(*robot, object); !status.ok()) {
        return status;
      }
      touched_[each] = std::move(object);
    }
    return absl::OkStatus();
  }

  std::vector<std::string> AttachedTo(const std::string& robot) const {
    std::vector<std::string> names;
    const auto add = [&](const WorldObject& object) {
      if (object.attachment != nullptr && object.attachment->robot == robot) {
        names.push_back(object.name);
      }
    };
    for (const WorldObjectPtr& object : base_.attached()) {
      if (!touched_.contains(object->name)) add(*object);
    }
    for (const auto& [touched, object] : touched_) {
      if (object.has_value()) add(*object);
    }
    return names;
  }

  WorldObject Added(const PutObject& put) const {
    WorldObject object;
    object.name = put.name;
    object.geometry = put.geometry;
    object.X_WO = put.X_WO;
    object.create_revision = revision_;
    object.geometry_revision = revision_;
    object.pose_revision = revision_;
    SetAttributes(object, put);
    return object;
  }

  WorldObject Replaced(const WorldObject& current, const PutObject& put) const {
    WorldObject object = Unplaced(current);
    if (put.geometry != current.geometry && !SameModel(*put.geometry->model, current.model())) {
      object.geometry = put.geometry;
      object.geometry_revision = revision_;
    }
    SetPoseAt(put.X_WO, object);
    SetAttributes(object, put);
    return object;
  }

  static void SetAttributes(WorldObject& object, const PutObject& put) {
    object.kind = put.kind;
    object.owner = put.owner;
    object.state = put.state;
    object.supported_by = put.supported_by;
    object.margin_m = put.margin_m;
  }

  const WorldSnapshot& base_;
  WorkCounter* const work_;
  Revision revision_;
  std::map<std::string, std::optional<WorldObject>, std::less<>> touched_;  // nullopt: removed
  RobotTransaction robots_;
  PairRuleTransaction rules_;
};

}  // namespace

const std::string& NameOf(const Change& change) {
  static const std::string& kNone = *new std::string;
  return std::visit(
      [](const auto& what) -> const std::string& {
        if constexpr (requires { what.name; }) return what.name;
        return kNone;
      },
      change.what);
}

bool IsPairRuleChange(const Change& change) {
  return std::holds_alternative<AllowCollision>(change.what) ||
         std::holds_alternative<SetPairMargin>(change.what) ||
         std::holds_alternative<ExpireRules>(change.what);
}

bool IsRobotChange(const Change& change) {
  return std::holds_alternative<PutRobot>(change.what) ||
         std::holds_alternative<RemoveRobot>(change.what) ||
         std::holds_alternative<SetRobotState>(change.what);
}

bool IsUnknownRobotFault(const Change& change, const ApplyFault& fault) {
  return IsRobotChange(change) ||
         (std::holds_alternative<AttachObject>(change.what) && fault.field == "robot");
}

std::optional<Revision> LatestRevisionOf(const WorldSnapshot& snapshot, const Change& change) {
  if (IsRobotChange(change)) {
    const WorldRobotPtr robot = snapshot.FindRobot(NameOf(change));
    return robot != nullptr ? std::optional(robot->latest_revision()) : std::nullopt;
  }
  const WorldObjectPtr object = snapshot.Find(NameOf(change));
  return object != nullptr ? std::optional(object->latest_revision()) : std::nullopt;
}

absl::StatusOr<std::shared_ptr<const WorldSnapshot>> Apply(
    const std::shared_ptr<const WorldSnapshot>& base, std::span<const Change> changes,
    WorkCounter* work) {
  Transaction transaction(*base, work);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (MustEnd(work, kStepsPerChange)) return absl::CancelledError("the changes were cancelled");
    const Change& change = changes[i];
    if (change.expected_object_revision.has_value()) {
      const absl::Status status =
          transaction.CheckExpected(change, *change.expected_object_revision);
      if (!status.ok()) return WithChangeIndex(i, status);
    }
    const absl::Status status = std::visit(transaction, change.what);
    if (!status.ok()) return WithChangeIndex(i, status);
  }
  const auto next = transaction.Finish();
  if (HasEnded(work)) return absl::CancelledError("the changes were cancelled");
  return next != nullptr ? next : base;
}

}  // namespace cwm::collision
