#include "server/core/ingest_plan.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "perception/cloud/parallel_for.h"

namespace cwm::server {
namespace {

using collision::ObjectKind;
using collision::ObjectState;
using collision::Owner;
using collision::PutObject;
using collision::WorldObject;
using collision::WorldObjectPtr;
using perception::Association;
using Outcome = Association::Outcome;

// True if no scan may change the object: it is owned by a user, or attached, in which case it is
// known to be at its link whether the scan shows it or not.
bool IsProtected(const WorldObject& object) {
  return object.owner == Owner::kUser || object.attachment != nullptr;
}

perception::KnownObject ToKnown(const WorldObject& object) {
  using Kind = perception::KnownObject::Kind;
  Kind kind = Kind::kObject;
  if (object.kind == ObjectKind::kSupport) kind = Kind::kSupport;
  if (object.kind == ObjectKind::kResidual) kind = Kind::kResidual;
  return {.name = object.name,
          .kind = kind,
          .owned_by_user = IsProtected(object),
          .X_WO = object.X_WO,
          .model = object.geometry->model};
}

PutObject ToPutObject(const WorldObject& object) {
  return {.name = object.name,
          .kind = object.kind,
          .owner = object.owner,
          .state = object.state,
          .X_WO = object.X_WO,
          .geometry = object.geometry,
          .supported_by = object.supported_by,
          .margin_m = object.margin_m};
}

// The outcome of an association in the given mode: in kAdd, nothing is moved, removed or marked as
// occluded.
Outcome InMode(Outcome what, IngestMode mode) {
  if (mode != IngestMode::kAdd) return what;
  if (what == Outcome::kMove || what == Outcome::kRemove || what == Outcome::kOcclude)
    return Outcome::kKeep;
  return what;
}

class Planner {
 public:
  Planner(const SceneMatch& match, const Detections& detections, IngestMode mode,
          DetectionGeometry& geometry)
      : match_(match), detections_(detections), mode_(mode), geometry_(geometry) {}

  absl::StatusOr<IngestPlan> Plan(const std::function<std::string(const std::string&)>& next_name) {
    if (const absl::Status covered = OrderByDetection(); !covered.ok()) return covered;
    NameDetections(next_name);
    CollectRemoved();
    for (int d = 0; d < detections_.size(); ++d) PlanDetection(d);
    for (const Association& association : match_.associations) {
      if (detections_.DetectionOf(association) < 0) PlanUnseen(association);
    }
    return std::move(plan_);
  }

 private:
  // Finds the one association of each detection, and checks all indices, since they come from
  // another module.
  absl::Status OrderByDetection() {
    by_detection_.assign(static_cast<std::size_t>(detections_.size()), nullptr);
    for (const Association& association : match_.associations) {
      const int d = detections_.DetectionOf(association);
      const bool known_needed =
          association.outcome != Outcome::kAdd && association.outcome != Outcome::kExplained;
      if (association.known >= static_cast<int>(match_.known.size()) ||
          (known_needed && association.known < 0) || d >= detections_.size() ||
          (d >= 0 && by_detection_[static_cast<std::size_t>(d)] != nullptr) ||
          (d < 0 && !known_needed)) {
        return absl::InternalError("ingest: an association contradicts the scene");
      }
      if (d >= 0) by_detection_[static_cast<std::size_t>(d)] = &association;
    }
    if (std::count(by_detection_.begin(), by_detection_.end(), nullptr) > 0) {
      return absl::InternalError("ingest: a detection has no association");
    }
    return absl::OkStatus();
  }

  const Association& AssociationOf(int d) const {
    return *by_detection_[static_cast<std::size_t>(d)];
  }
  const WorldObject* KnownOf(const Association& association) const {
    return association.known < 0 ? nullptr
                                 : match_.known[static_cast<std::size_t>(association.known)].get();
  }
  static bool IsProtectedKnown(const WorldObject* known) {
    return known != nullptr && IsProtected(*known);
  }

  void NameDetections(const std::function<std::string(const std::string&)>& next_name) {
    for (int d = 0; d < detections_.size(); ++d) {
      const Association& association = AssociationOf(d);
      if (const WorldObject* known = KnownOf(association); known != nullptr) {
        plan_.names.push_back(known->name);
      } else if (association.outcome == Outcome::kAdd) {
        plan_.names.push_back(next_name(StemOf(detections_.kind(d))));
      } else {
        plan_.names.emplace_back();
      }
    }
  }

  void CollectRemoved() {
    for (const Association& association : match_.associations) {
      const WorldObject* known = KnownOf(association);
      if (InMode(association.outcome, mode_) == Outcome::kRemove && !IsProtectedKnown(known)) {
        removed_.insert(known->name);
      }
    }
  }

  // The name of the detection's supporter, as the scan shows it.
  std::string ScannedSupporter(int d) const {
    const int supporter = detections_.supported_by(d);
    return supporter < 0 ? "" : plan_.names[static_cast<std::size_t>(supporter)];
  }

  void PlanDetection(int d) {
    const Association& association = AssociationOf(d);
    const WorldObject* known = KnownOf(association);
    if (association.outcome == Outcome::kExplained || IsProtectedKnown(known)) return;
    switch (InMode(association.outcome, mode_)) {
      case Outcome::kAdd:
        Add(d);
        return;
      case Outcome::kReplace:
        Replace(*known, d);
        return;
      case Outcome::kMove:
        Move(*known, d, association.X_WO);
        return;
      default:
        Keep(*known, d);
        return;
    }
  }

  void Add(int d) {
    const std::string& name = plan_.names[static_cast<std::size_t>(d)];
    plan_.added.push_back(name);
    Emit(PutObject{.name = name,
                   .kind = detections_.kind(d),
                   .owner = Owner::kPerception,
                   .state = ObjectState::kConfirmed,
                   .X_WO = detections_.X_WO(d),
                   .geometry = geometry_.Prepared(d),
                   .supported_by = ScannedSupporter(d),
                   .margin_m = 0});
  }

  void Replace(const WorldObject& known, int d) {
    plan_.replaced.push_back(known.name);
    PutObject put = ToPutObject(known);
    put.kind = detections_.kind(d);
    put.state = ObjectState::kConfirmed;
    put.X_WO = detections_.X_WO(d);
    put.geometry = geometry_.Prepared(d);
    put.supported_by = ScannedSupporter(d);
    Emit(std::move(put));
  }

  void Move(const WorldObject& known, int d, const Pose& X_WO) {
    plan_.moved.push_back(known.name);
    PutObject put = ToPutObject(known);
    put.state = ObjectState::kConfirmed;
    put.X_WO = X_WO;
    put.supported_by = ScannedSupporter(d);
    Emit(std::move(put));
  }

  void Keep(const WorldObject& known, int d) {
    plan_.kept.push_back(known.name);
    EmitState(known, ObjectState::kConfirmed, ScannedSupporter(d));
  }

  // Plans for known objects that the scan does not show.
  void PlanUnseen(const Association& association) {
    const WorldObject& known = *KnownOf(association);
    if (IsProtectedKnown(&known)) return;
    switch (InMode(association.outcome, mode_)) {
      case Outcome::kRemove:
        plan_.removed.push_back(known.name);
        plan_.changes.push_back({collision::RemoveObject{known.name}, std::nullopt});
        return;
      case Outcome::kOcclude:
        plan_.occluded.push_back(known.name);
        EmitState(known, ObjectState::kOccluded, "");
        return;
      default:
        EmitState(known, known.state, "");
        return;
    }
  }

  // Emits the state of an object that stays where it is. Its supporter is corrected only if the old
  // one was removed.
  void EmitState(const WorldObject& known, ObjectState state,
                 const std::string& scanned_supporter) {
    const bool lost_supporter = removed_.count(known.supported_by) > 0;
    if (known.state == state && !lost_supporter) return;
    PutObject put = ToPutObject(known);
    put.state = state;
    if (lost_supporter) put.supported_by = scanned_supporter;
    Emit(std::move(put));
  }

  void Emit(PutObject put) { plan_.changes.push_back({std::move(put), std::nullopt}); }

  const SceneMatch& match_;
  const Detections& detections_;
  const IngestMode mode_;
  DetectionGeometry& geometry_;
  std::vector<const Association*> by_detection_;
  std::set<std::string> removed_;
  IngestPlan plan_;
};

}  // namespace

int Detections::DetectionOf(const Association& association) const {
  if (association.support >= 0) return association.support;
  return association.object < 0 ? -1 : supports() + association.object;
}

const Pose& Detections::X_WO(int detection) const {
  return detection < supports()
             ? scene_.supports[static_cast<std::size_t>(detection)].X_WO
             : scene_.objects[static_cast<std::size_t>(detection - supports())].X_WO;
}

const std::shared_ptr<const HybridModel>& Detections::model(int detection) const {
  return detection < supports()
             ? scene_.supports[static_cast<std::size_t>(detection)].model
             : scene_.objects[static_cast<std::size_t>(detection - supports())].model;
}

ObjectKind Detections::kind(int detection) const {
  if (detection < supports()) return ObjectKind::kSupport;
  const auto kind = scene_.objects[static_cast<std::size_t>(detection - supports())].kind;
  return kind == perception::DetectedKind::kResidual ? ObjectKind::kResidual : ObjectKind::kObject;
}

int Detections::supported_by(int detection) const {
  if (detection < supports()) return -1;
  const perception::DetectedObject& object =
      scene_.objects[static_cast<std::size_t>(detection - supports())];
  return object.rests_on >= 0 ? supports() + object.rests_on : object.supported_by;
}

SceneMatch MatchScene(SnapshotPtr snapshot, const perception::SceneInterpretation& scene,
                      const perception::PointCloud& cloud, const perception::SensorNoise& noise) {
  std::vector<WorldObjectPtr> known;
  for (const WorldObjectPtr& object : snapshot->objects()) {
    // Free space is no object, and movers are nothing that a scan would know again.
    if (object->kind == ObjectKind::kUnseen || object->kind == ObjectKind::kMover) continue;
    known.push_back(object);
  }
  return MatchScene(std::move(snapshot), std::move(known), scene, cloud, noise);
}

SceneMatch MatchScene(SnapshotPtr snapshot, std::vector<WorldObjectPtr> known,
                      const perception::SceneInterpretation& scene,
                      const perception::PointCloud& cloud, const perception::SensorNoise& noise) {
  SceneMatch match;
  std::vector<perception::KnownObject> seen;
  seen.reserve(known.size());
  for (const WorldObjectPtr& object : known) {
    seen.push_back(ToKnown(*object));
    seen.back().is_gone = snapshot->Find(object->name) == nullptr;
  }
  match.associations = perception::Associate(seen, scene, cloud, noise);
  match.known = std::move(known);
  match.snapshot = std::move(snapshot);
  return match;
}

std::shared_ptr<const collision::PreparedModel> DetectionGeometry::Prepared(int detection) {
  auto& prepared = prepared_[static_cast<std::size_t>(detection)];
  if (prepared == nullptr) prepared = collision::Prepare(detections_.model(detection));
  return prepared;
}

absl::Status DetectionGeometry::PrepareFor(const SceneMatch& match, IngestMode mode,
                                           const perception::Work& work) {
  std::vector<int> wanted;
  for (const Association& association : match.associations) {
    const Outcome what = InMode(association.outcome, mode);
    const int d = detections_.DetectionOf(association);
    if ((what == Outcome::kAdd || what == Outcome::kReplace) && d >= 0 && d < detections_.size()) {
      wanted.push_back(d);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  try {
    perception::ParallelFor(wanted.size(), 1, work, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) Prepared(wanted[k]);
    });
  } catch (const perception::Stopped&) {
    return absl::CancelledError("ingest: the caller went away");
  }
  return absl::OkStatus();
}

absl::StatusOr<IngestPlan> PlanIngest(
    const SceneMatch& match, const Detections& detections, IngestMode mode,
    DetectionGeometry& geometry,
    const std::function<std::string(const std::string& stem)>& next_name) {
  return Planner(match, detections, mode, geometry).Plan(next_name);
}

std::string StemOf(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::kSupport:
      return "support";
    case ObjectKind::kResidual:
      return "residual";
    default:
      return "object";
  }
}

}  // namespace cwm::server
