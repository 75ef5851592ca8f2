#include "server/store/world_fold.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/world/world_object.h"
#include "server/core/approximate_bytes.h"
#include "server/store/decode_fault.h"
#include "server/store/decode_values.h"

namespace cwm::server {
namespace {

// No sum of revisions overflows.
constexpr std::int64_t kMaxRevision = std::int64_t{1} << 62;

// A mesh has about twice as many triangles as vertices.
void AddMesh(const store::v1::Mesh& mesh, MeshTotals& totals) {
  constexpr std::int64_t kBytesPerTriangle = 24;
  const std::int64_t bytes = mesh.has_blob() ? std::max<std::int64_t>(0, mesh.blob().bytes())
                                             : static_cast<std::int64_t>(mesh.mesh_f64().size());
  totals.triangles += bytes / kBytesPerTriangle;
  totals.vertices += bytes / kBytesPerTriangle / 2;
}

std::int64_t PreparedBytesOf(const store::v1::Model& model) {
  MeshTotals totals;
  for (const store::v1::ShapePart& part : model.shapes()) {
    if (part.shape().has_mesh()) AddMesh(part.shape().mesh(), totals);
    if (part.shape().has_convex()) AddMesh(part.shape().convex(), totals);
  }
  for (const store::v1::SurfacePart& part : model.surfaces()) AddMesh(part.surface(), totals);
  for (const store::v1::Handle& handle : model.handles()) AddMesh(handle.surface(), totals);
  const int parts = model.shapes_size() + model.surfaces_size() + model.handles_size();
  return ApproximatePreparedBytes(parts, totals);
}

std::shared_ptr<const FoldedModel> TakeModel(store::v1::Object& object, bool observed) {
  auto model = std::make_shared<FoldedModel>();
  model->model.Swap(object.mutable_model());
  object.clear_model();
  model->observed = observed;
  model->prepared_bytes = PreparedBytesOf(model->model);
  return model;
}

template <class Ptr>
void SetOrErase(std::unordered_map<std::string, Ptr>& members, const std::string& name,
                const Ptr& member) {
  if (member == nullptr) {
    members.erase(name);
  } else {
    members[name] = member;
  }
}

const std::string& NameOfEither(const FoldedObjectDelta& delta) {
  return (delta.after != nullptr ? delta.after : delta.before)->object.name();
}
const std::string& NameOfEither(const FoldedRobotDelta& delta) {
  return (delta.after != nullptr ? delta.after : delta.before)->name();
}

template <class Members>
auto FindIn(const Members& members, const std::string& name) {
  const auto found = members.find(name);
  return found == members.end() ? typename Members::mapped_type() : found->second;
}

template <class Members>
std::vector<typename Members::const_iterator> InOrder(const Members& members) {
  std::vector<typename Members::const_iterator> order;
  order.reserve(members.size());
  for (auto at = members.begin(); at != members.end(); ++at) order.push_back(at);
  std::ranges::sort(order, {}, [](const auto& at) -> const std::string& { return at->first; });
  return order;
}

std::string Quote(const std::string& name) { return absl::StrCat("'", name.substr(0, 128), "'"); }

bool IsWorldName(const std::string& name) {
  return collision::IsValidName(name) && name.find('/') == std::string::npos;
}

}  // namespace

std::string RuleKey(const store::v1::PairRule& rule) {
  // No name contains the zero byte, so keys are in the order of pairs.
  std::string key = rule.a().name();
  for (const std::string* part : {&rule.a().link(), &rule.b().name(), &rule.b().link()}) {
    key.push_back('\0');
    key += *part;
  }
  return key;
}

bool IsEmptyRule(const store::v1::PairRule& rule) {
  return !rule.allowed() && !rule.has_margin_m() && !rule.check();
}

std::int64_t FoldedEvent::superseded_bytes() const {
  std::int64_t bytes = 0;
  for (const FoldedObjectDelta& delta : objects) {
    if (delta.before == nullptr) continue;
    const bool is_kept = delta.after != nullptr && delta.after->model == delta.before->model;
    if (!is_kept) bytes += delta.before->model->prepared_bytes;
  }
  return bytes;
}

void FoldedState::Apply(const FoldedEvent& event) {
  revision = event.revision;
  for (const FoldedObjectDelta& delta : event.objects) {
    SetOrErase(objects, NameOfEither(delta), delta.after);
  }
  for (const FoldedRobotDelta& delta : event.robots) {
    SetOrErase(robots, NameOfEither(delta), delta.after);
  }
  for (const FoldedRuleDelta& delta : event.rules) SetRule(delta.after);
}

void FoldedState::SetRule(const store::v1::PairRule& rule) {
  if (IsEmptyRule(rule)) {
    rules.erase(RuleKey(rule));
  } else {
    rules[RuleKey(rule)] = rule;
  }
}

void FoldedState::Undo(const FoldedEvent& event) {
  revision = event.before;
  for (auto delta = event.objects.rbegin(); delta != event.objects.rend(); ++delta) {
    SetOrErase(objects, NameOfEither(*delta), delta->before);
  }
  for (auto delta = event.robots.rbegin(); delta != event.robots.rend(); ++delta) {
    SetOrErase(robots, NameOfEither(*delta), delta->before);
  }
  for (auto delta = event.rules.rbegin(); delta != event.rules.rend(); ++delta) {
    if (delta->before) {
      SetRule(*delta->before);
    } else {
      rules.erase(RuleKey(delta->after));
    }
  }
}

absl::StatusOr<WorldFold> WorldFold::FromSnapshot(store::v1::WorldSnapshot snapshot,
                                                  const Retention& retention) {
  WorldFold fold(retention);
  fold.uid_ = snapshot.world_uid();
  fold.name_ = snapshot.name();
  if (!IsWorldName(fold.name_)) return Broken("name", "must be the name of a world");
  fold.newest_when_ns_ = snapshot.newest_when_ns();
  fold.state_.revision = snapshot.revision();
  if (snapshot.revision() < 0 || snapshot.revision() > kMaxRevision) {
    return Broken("revision", "must be from 0 to 2^62");
  }
  for (store::v1::Object& object : *snapshot.mutable_objects()) {
    if (!object.has_model()) return Broken("objects", "has one without a model");
    const bool observed = object.observed_model();
    object.clear_observed_model();
    auto model = TakeModel(object, observed);
    std::string name = object.name();
    auto folded = std::make_shared<const FoldedObject>(
        FoldedObject{.object = std::move(object), .model = std::move(model)});
    const bool is_new = fold.state_.objects.emplace(name, std::move(folded)).second;
    if (!is_new) return Broken("objects", absl::StrCat("has ", Quote(name), " twice"));
  }
  for (store::v1::Robot& robot : *snapshot.mutable_robots()) {
    std::string name = robot.name();
    if (!robot.has_files()) return Broken("robots", "has one without files");
    if (fold.state_.objects.contains(name)) {
      return Broken("robots", absl::StrCat("has ", Quote(name), ", the name of an object"));
    }
    auto folded = std::make_shared<const store::v1::Robot>(std::move(robot));
    const bool is_new = fold.state_.robots.emplace(name, std::move(folded)).second;
    if (!is_new) return Broken("robots", absl::StrCat("has ", Quote(name), " twice"));
  }
  for (store::v1::PairRule& rule : *snapshot.mutable_rules()) {
    fold.state_.rules[RuleKey(rule)] = std::move(rule);
  }
  for (store::v1::SensorPose& pose : *snapshot.mutable_sensor_poses()) {
    const std::string sensor = pose.sensor();
    fold.sensor_poses_[sensor] = std::move(pose);
  }
  for (store::v1::AnsweredRequest& request : *snapshot.mutable_requests()) {
    fold.requests_.push_back(std::move(request));
  }
  for (const store::v1::LastNumber& last : snapshot.last_numbers()) {
    fold.last_numbers_[last.stem()] = last.number();
  }
  for (const store::v1::Observation& observation : snapshot.observations()) {
    NumberedObservation& known = fold.observations_[observation.name()];
    if (observation.has_last_ns()) known.observation.last = WallTimeOf(observation.last_ns());
    if (observation.has_reachable()) known.observation.reachable = observation.reachable();
    known.number = ++fold.last_observation_;
  }
  return fold;
}

absl::Status WorldFold::CheckFollows(const store::v1::Record& record) const {
  const bool is_first = uid_.empty();
  if (record.world_uid().empty()) return Broken("world_uid", "is absent");
  if (!is_first && record.world_uid() != uid_) return Broken("world_uid", "is of another world");
  if (is_first && !IsWorldName(record.created_name())) {
    return Broken("created_name", "must be the name of a world in its first record");
  }
  if (!is_first && !record.created_name().empty()) {
    return Broken("created_name", "came twice, must come once");
  }
  if (end_) return Broken("world_uid", "is of a world that was deleted");
  if (record.has_write() == record.has_deletion()) {
    return Broken("write", "must be given, or deletion");
  }
  const bool makes_revision = record.has_write() && record.write().makes_revision();
  const std::int64_t skipped = record.write().skipped_revisions();
  if (skipped < 0 || skipped > kMaxRevision - state_.revision - 1) {
    return Broken("write.skipped_revisions",
                  absl::StrCat("is ", skipped, ", must not be negative, nor lead beyond 2^62"));
  }
  if (!makes_revision && (skipped > 0 || record.write().drops_past())) {
    return Broken("write.makes_revision", "must be true: revisions are skipped or dropped");
  }
  const std::int64_t next = state_.revision + (makes_revision ? 1 + skipped : 0);
  if (record.revision() == next) return absl::OkStatus();
  return Broken("revision", absl::StrCat("is ", record.revision(), ", must be ", next));
}

absl::StatusOr<std::optional<FoldedEvent>> WorldFold::Apply(store::v1::Record record) {
  if (absl::Status status = CheckFollows(record); !status.ok()) return status;
  if (uid_.empty()) {
    uid_ = record.world_uid();
    name_ = record.created_name();
  }
  newest_when_ns_ = std::max(newest_when_ns_, record.when_ns());
  if (record.has_deletion()) {
    end_ = End{.deletion = std::move(*record.mutable_deletion()), .when_ns = record.when_ns()};
    return std::optional<FoldedEvent>();
  }
  absl::StatusOr<FoldedEvent> event = TakeChanges(record);
  if (!event.ok()) return Within("write", event.status());
  TakeFacts(record);
  if (!record.write().makes_revision()) return std::optional<FoldedEvent>();
  state_.revision = record.revision();
  return std::optional<FoldedEvent>(*std::move(event));
}

absl::StatusOr<FoldedEvent> WorldFold::TakeChanges(store::v1::Record& record) {
  store::v1::Write& write = *record.mutable_write();
  FoldedEvent event{.before = state_.revision,
                    .revision = record.revision(),
                    .when_ns = record.when_ns(),
                    .drops_past = write.drops_past()};
  for (store::v1::ObjectChange& change : *write.mutable_objects()) {
    absl::Status status = TakeObject(change, record.observed(), event);
    if (!status.ok()) return Within("objects", status);
  }
  for (store::v1::RobotChange& change : *write.mutable_robots()) {
    if (absl::Status status = TakeRobot(change, event); !status.ok()) {
      return Within("robots", status);
    }
  }
  for (store::v1::PairRule& rule : *write.mutable_rules()) {
    FoldedRuleDelta delta;
    const auto known = state_.rules.find(RuleKey(rule));
    if (known != state_.rules.end()) delta.before = known->second;
    delta.after = std::move(rule);
    state_.SetRule(delta.after);
    event.rules.push_back(std::move(delta));
  }
  if (event.size() > 0 && !write.makes_revision()) {
    return Broken("makes_revision", "must be true: there are changes");
  }
  for (const FoldedObjectDelta& delta : event.objects) {
    if (delta.after == nullptr || !state_.robots.contains(delta.after->object.name())) continue;
    return Broken("objects",
                  absl::StrCat("has ", Quote(delta.after->object.name()), ", the name of a robot"));
  }
  for (const FoldedRobotDelta& delta : event.robots) {
    if (delta.after == nullptr || !state_.objects.contains(delta.after->name())) continue;
    return Broken("robots",
                  absl::StrCat("has ", Quote(delta.after->name()), ", the name of an object"));
  }
  return event;
}

absl::Status WorldFold::TakeObject(store::v1::ObjectChange& change, bool observed,
                                   FoldedEvent& event) {
  const std::string& name = change.name();
  FoldedObjectDelta delta{.before = FindIn(state_.objects, name), .after = {}};
  if (!change.has_after()) {
    if (delta.before == nullptr) return Broken("name", Quote(name) + " does not exist");
    observations_.erase(name);
    state_.objects.erase(name);
    event.objects.push_back(std::move(delta));
    return absl::OkStatus();
  }
  if (change.after().name() != name) return Broken("after.name", "must be the name");
  auto after = std::make_shared<FoldedObject>();
  after->object.Swap(change.mutable_after());
  if (after->object.has_model()) {
    after->model = TakeModel(after->object, observed);
  } else if (delta.before != nullptr) {
    after->model = delta.before->model;
  } else {
    return Broken("after.model", absl::StrCat("of ", Quote(name), " is absent: it is new"));
  }
  delta.after = std::move(after);
  state_.objects[name] = delta.after;
  event.objects.push_back(std::move(delta));
  return absl::OkStatus();
}

absl::Status WorldFold::TakeRobot(store::v1::RobotChange& change, FoldedEvent& event) {
  const std::string& name = change.name();
  FoldedRobotDelta delta{.before = FindIn(state_.robots, name), .after = {}};
  if (!change.has_after()) {
    if (delta.before == nullptr) return Broken("name", Quote(name) + " does not exist");
  } else {
    if (change.after().name() != name) return Broken("after.name", "must be the name");
    auto after = std::make_shared<store::v1::Robot>();
    after->Swap(change.mutable_after());
    if (!after->has_files()) {
      if (delta.before == nullptr) {
        return Broken("after.files", absl::StrCat("of ", Quote(name), " are absent: it is new"));
      }
      *after->mutable_files() = delta.before->files();
    }
    delta.after = std::move(after);
  }
  SetOrErase(state_.robots, name, delta.after);
  event.robots.push_back(std::move(delta));
  return absl::OkStatus();
}

void WorldFold::TakeFacts(store::v1::Record& record) {
  store::v1::Write& write = *record.mutable_write();
  for (const store::v1::Sighting& sighting : write.sightings()) {
    if (!state_.objects.contains(sighting.name())) continue;
    NumberedObservation& known = observations_[sighting.name()];
    const bool is_newer =
        AddSighting(DecodeSighting(sighting), WallTimeOf(write.seen_at_ns()), known.observation);
    if (is_newer) known.number = ++last_observation_;
  }
  if (write.has_sensor_pose()) {
    const std::string sensor = write.sensor_pose().sensor();
    sensor_poses_[sensor] = std::move(*write.mutable_sensor_pose());
  }
  for (const store::v1::LastNumber& last : write.last_numbers()) {
    std::int64_t& known = last_numbers_[last.stem()];
    known = std::max(known, last.number());
  }
  if (!write.has_request()) return;
  store::v1::AnsweredRequest request;
  *request.mutable_request() = std::move(*write.mutable_request());
  request.set_revision(record.revision());
  request.set_when_ns(record.when_ns());
  KeepRequest(std::move(request));
}

void WorldFold::KeepRequest(store::v1::AnsweredRequest request) {
  const std::int64_t kept_ns = std::chrono::nanoseconds(retention_.request_id_time).count();
  const std::int64_t now_ns = request.when_ns();
  requests_.push_back(std::move(request));
  // Divided, so that no clock of a damaged store overflows.
  const auto is_old = [&](const store::v1::AnsweredRequest& each) {
    return each.when_ns() / 2 < now_ns / 2 - kept_ns / 2;
  };
  while (is_old(requests_.front()) ||
         static_cast<std::int64_t>(requests_.size()) > retention_.request_ids) {
    requests_.pop_front();
  }
}

std::vector<store::v1::AnsweredRequest> WorldFold::Requests() const {
  std::vector<store::v1::AnsweredRequest> requests;
  std::unordered_set<std::string_view> ids;  // an id may be used again when it is forgotten
  for (auto at = requests_.rbegin(); at != requests_.rend(); ++at) {
    if (ids.insert(at->request().id()).second) requests.push_back(*at);
  }
  std::ranges::reverse(requests);
  return requests;
}

std::vector<WorldFold::NamedObservation> WorldFold::Observations() const {
  std::vector<const std::pair<const std::string, NumberedObservation>*> order;
  order.reserve(observations_.size());
  for (const auto& entry : observations_) order.push_back(&entry);
  std::ranges::sort(order, {}, [](const auto* entry) { return entry->second.number; });
  std::vector<NamedObservation> observations;
  observations.reserve(order.size());
  for (const auto* entry : order) {
    observations.push_back({.name = entry->first, .observation = entry->second.observation});
  }
  return observations;
}

void AddObject(const FoldedObject& object, store::v1::WorldSnapshot& snapshot) {
  store::v1::Object* const added = snapshot.add_objects();
  *added = object.object;
  *added->mutable_model() = object.model->model;
  added->set_observed_model(object.model->observed);
}

std::vector<FoldedObjectPtr> WorldFold::ObjectsInOrder() const {
  std::vector<FoldedObjectPtr> objects;
  objects.reserve(state_.objects.size());
  for (const auto& at : InOrder(state_.objects)) objects.push_back(at->second);
  return objects;
}

store::v1::WorldSnapshot WorldFold::Snapshot() const {
  store::v1::WorldSnapshot snapshot = SnapshotWithoutObjects();
  for (const FoldedObjectPtr& object : ObjectsInOrder()) AddObject(*object, snapshot);
  return snapshot;
}

store::v1::WorldSnapshot WorldFold::SnapshotWithoutObjects() const {
  store::v1::WorldSnapshot snapshot;
  snapshot.set_world_uid(uid_);
  snapshot.set_name(name_);
  snapshot.set_revision(state_.revision);
  snapshot.set_newest_when_ns(newest_when_ns_);
  for (const auto& at : InOrder(state_.robots)) *snapshot.add_robots() = *at->second;
  for (const auto& [key, rule] : state_.rules) *snapshot.add_rules() = rule;
  for (const auto& [sensor, pose] : sensor_poses_) *snapshot.add_sensor_poses() = pose;
  for (store::v1::AnsweredRequest& request : Requests()) {
    *snapshot.add_requests() = std::move(request);
  }
  for (const auto& [stem, number] : last_numbers_) {
    store::v1::LastNumber* const last = snapshot.add_last_numbers();
    last->set_stem(stem);
    last->set_number(number);
  }
  for (const NamedObservation& each : Observations()) {
    store::v1::Observation* const added = snapshot.add_observations();
    added->set_name(each.name);
    if (each.observation.last) {
      added->set_last_ns(std::chrono::duration_cast<std::chrono::nanoseconds>(
                             each.observation.last->time_since_epoch())
                             .count());
    }
    if (each.observation.reachable) added->set_reachable(*each.observation.reachable);
  }
  return snapshot;
}

}  // namespace cwm::server
