// Apply: a list of changes, whole or not at all.
#include <cmath>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/world/model_equality.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {
namespace {

// What the snapshot and the tree over it rely on: finite, in range, a proper rotation. The wire
// layer refuses the rest with the name of the field; this is the last door.
bool IsPlaceable(const Pose& X_WO) {
  constexpr double kOrthonormality = 1e-6;  // far above rounding, far below a visible shear
  const Matrix3 R = X_WO.linear();
  return X_WO.matrix().allFinite() &&
         X_WO.translation().cwiseAbs().maxCoeff() <= kLargestCoordinate_m &&
         (R.transpose() * R - Matrix3::Identity()).cwiseAbs().maxCoeff() <= kOrthonormality &&
         R.determinant() > 0;
}

absl::Status BadPose() {
  return absl::InvalidArgumentError(
      absl::StrCat("pose must be a finite rigid transform within ", kLargestCoordinate_m, " m"));
}

// An object that no one can tell from `b`, its revisions aside.
bool SameContent(const WorldObject& a, const WorldObject& b) {
  return a.name == b.name && a.uid == b.uid && a.kind == b.kind && a.owner == b.owner &&
         a.state == b.state && SamePose(a.X_WO, b.X_WO) && a.geometry == b.geometry &&
         a.supported_by == b.supported_by && a.margin_m == b.margin_m;
}

// The objects that a list of changes touches, over an untouched base. Nothing is placed (the costly
// part of an object) before the whole list has been accepted.
class Transaction {
 public:
  explicit Transaction(const WorldSnapshot& base)
      : base_(base), revision_{base.revision().value + 1} {}

  absl::Status operator()(const PutObject& put) {
    if (!IsValidName(put.name)) {
      return absl::InvalidArgumentError(
          absl::StrCat("name '", put.name, "' must be 1 to 128 letters, digits or \"_-./\""));
    }
    if (!IsPlaceable(put.X_WO)) return BadPose();
    if (put.geometry == nullptr) return absl::InvalidArgumentError("geometry must be given");
    if (!std::isfinite(put.margin_m) || put.margin_m < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("margin_m ", put.margin_m, " must be finite and not negative"));
    }
    const WorldObject* current = Current(put.name);
    touched_[put.name] = current != nullptr ? Replaced(*current, put) : Added(put);
    return absl::OkStatus();
  }

  absl::Status operator()(const MoveObject& move) {
    const WorldObject* current = Current(move.name);
    if (current == nullptr) return Missing(move.name);
    if (!IsPlaceable(move.X_WO)) return BadPose();
    WorldObject moved = *current;
    SetPose(moved, move.X_WO);
    touched_[move.name] = std::move(moved);
    return absl::OkStatus();
  }

  absl::Status operator()(const RemoveObject& remove) {
    if (Current(remove.name) == nullptr) return Missing(remove.name);
    touched_[remove.name] = std::nullopt;
    return absl::OkStatus();
  }

  absl::Status CheckExpected(const std::string& name, Revision expected) const {
    const WorldObjectPtr object = base_.Find(name);
    if (object == nullptr) {
      return absl::AbortedError(absl::StrCat("object '", name, "' does not exist, expected at ",
                                             "revision ", expected.value));
    }
    if (object->latest_revision() == expected) return absl::OkStatus();
    return absl::AbortedError(absl::StrCat("object '", name, "' is at revision ",
                                           object->latest_revision().value, ", expected ",
                                           expected.value));
  }

  // The next snapshot; nullptr when it would equal the base.
  std::shared_ptr<const WorldSnapshot> Finish() {
    std::vector<WorldObjectPtr> objects;
    objects.reserve(base_.objects().size() + touched_.size());
    bool changed = false;
    auto base = base_.objects().begin();
    for (auto& [name, object] : touched_) {
      while (base != base_.objects().end() && (*base)->name < name) objects.push_back(*base++);
      WorldObjectPtr before;
      if (base != base_.objects().end() && (*base)->name == name) before = *base++;
      if (before != nullptr && object.has_value() && SameContent(*before, *object)) {
        objects.push_back(std::move(before));
        continue;
      }
      changed = changed || before != nullptr || object.has_value();
      if (object.has_value()) objects.push_back(Place(*std::move(object)));
    }
    if (!changed) return nullptr;
    objects.insert(objects.end(), base, base_.objects().end());
    return std::make_shared<const WorldSnapshot>(revision_, std::move(objects));
  }

 private:
  static absl::Status Missing(const std::string& name) {
    return absl::NotFoundError(absl::StrCat("object '", name, "' does not exist"));
  }

  // The object as the list has left it so far; nullptr when there is none. Valid until the next
  // change of that object.
  const WorldObject* Current(const std::string& name) const {
    const auto at = touched_.find(name);
    if (at != touched_.end()) return at->second.has_value() ? &*at->second : nullptr;
    return base_.Find(name).get();  // kept alive by the base
  }

  void SetPose(WorldObject& object, const Pose& X_WO) const {
    if (SamePose(object.X_WO, X_WO)) return;
    object.X_WO = X_WO;
    object.pose_revision = revision_;
  }

  WorldObject Added(const PutObject& put) const {
    WorldObject object;
    object.name = put.name;
    // One object of a name can be made per revision, so the two together are unique for ever.
    object.uid = absl::StrCat(put.name, "@", revision_.value);
    object.geometry = put.geometry;
    object.X_WO = put.X_WO;
    object.create_revision = revision_;
    object.geometry_revision = revision_;
    object.pose_revision = revision_;
    SetAttributes(object, put);
    return object;
  }

  WorldObject Replaced(const WorldObject& current, const PutObject& put) const {
    WorldObject object = current;
    if (put.geometry != current.geometry && !SameModel(*put.geometry->model, current.model())) {
      object.geometry = put.geometry;
      object.geometry_revision = revision_;
    }
    SetPose(object, put.X_WO);
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
  Revision revision_;
  std::map<std::string, std::optional<WorldObject>, std::less<>> touched_;  // nullopt: removed
};

absl::Status AtIndex(std::size_t index, const absl::Status& status) {
  return {status.code(), absl::StrCat("changes[", index, "]: ", status.message())};
}

}  // namespace

absl::StatusOr<std::shared_ptr<const WorldSnapshot>> Apply(
    const std::shared_ptr<const WorldSnapshot>& base, std::span<const Change> changes) {
  Transaction transaction(*base);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const Change& change = changes[i];
    if (change.expected_object_revision.has_value()) {
      const std::string& name =
          std::visit([](const auto& what) -> const std::string& { return what.name; }, change.what);
      const absl::Status status = transaction.CheckExpected(name, *change.expected_object_revision);
      if (!status.ok()) return AtIndex(i, status);
    }
    const absl::Status status = std::visit(transaction, change.what);
    if (!status.ok()) return AtIndex(i, status);
  }
  auto next = transaction.Finish();
  return next != nullptr ? std::move(next) : base;
}

}  // namespace cwm::collision
