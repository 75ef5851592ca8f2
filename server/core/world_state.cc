#include "server/core/world_state.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/refusal.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;

bool IsShortOfMemory(const absl::Status& status) {
  return absl::IsResourceExhausted(status) && DetailsOf(status).reason == "MEMORY_EXHAUSTED";
}

// True if forgetting the past of all worlds may make enough room: a request for a quarter of the
// worlds' limit or more does not justify it.
bool MayFit(const absl::Status& refusal, const MemoryBudget& memory) {
  const ErrorDetails details = DetailsOf(refusal);
  const auto asked = details.metadata.find("asked_bytes");
  std::int64_t bytes = 0;
  return asked != details.metadata.end() && absl::SimpleAtoi(asked->second, &bytes) &&
         bytes < memory.worlds_limit_bytes() / 4;
}

absl::Status TooManyPending(std::int64_t limit) {
  // chosen: the disk writes thousands of them in a second.
  constexpr double kRetryAfter_s = 0.2;
  return Overloaded(absl::StrCat(limit, " writes of this world wait for the disk"), "QUEUE_FULL",
                    kRetryAfter_s);
}

absl::Status RevisionMismatch(Revision expected, Revision actual) {
  return MakeError(
      absl::StatusCode::kAborted,
      absl::StrCat("expected_revision: is ", expected.value, ", the world is at ", actual.value),
      {.reason = "REVISION_MISMATCH",
       .metadata = {{"expected_revision", std::to_string(expected.value)},
                    {"actual_revision", std::to_string(actual.value)}}});
}

}  // namespace

absl::StatusOr<std::optional<WriteOutcome>> World::State::Precheck(const WriteOptions& options) {
  if (is_closed) return WorldDeleted();
  absl::StatusOr<std::optional<WriteOutcome>> first = requests.Find(options, now());
  if (!first.ok() || first->has_value()) return first;
  if (!options.expected_revision.has_value()) return std::nullopt;
  const Revision latest = pipeline->Tip()->revision();
  if (*options.expected_revision != latest) {
    return RevisionMismatch(*options.expected_revision, latest);
  }
  return std::nullopt;
}

void World::State::ScheduleExpiry() {
  if (services.expiry == nullptr) return;
  const std::lock_guard lock(expiry_mutex);
  services.expiry->Set(uid, world->weak_from_this(),
                       collision::NextExpiry(feed->Latest()->pair_rules()));
}

absl::Status World::State::ChargeGeometry(const collision::WorldSnapshot& base,
                                          std::vector<Change>& changes) const {
  for (Change& change : changes) {
    if (auto* put = std::get_if<collision::PutObject>(&change.what)) {
      const collision::WorldObjectPtr known = base.Find(put->name);
      if (known != nullptr && known->geometry == put->geometry) continue;
      auto charge = memory->Charge(payer, ApproximateBytes(*put));
      if (!charge.ok()) return charge.status();
      put->geometry = WithCharge(std::move(put->geometry), *std::move(charge));
    } else if (auto* put_robot = std::get_if<collision::PutRobot>(&change.what)) {
      auto charge = memory->Charge(payer, ApproximateBytes(*put_robot->robot));
      if (!charge.ok()) return charge.status();
      put_robot->robot = WithCharge(std::move(put_robot->robot), *std::move(charge));
    }
  }
  return absl::OkStatus();
}

absl::Status World::State::KeepGeometryOf(std::span<const Change> changes,
                                          Durability durability) const {
  if (services.journal == nullptr) return absl::OkStatus();
  const SnapshotPtr tip = pipeline->Tip();
  std::vector<PreparedModelPtr> models;
  for (const Change& change : changes) {
    if (const auto* put = std::get_if<collision::PutObject>(&change.what)) {
      models.push_back(put->geometry);
    } else if (durability == Durability::kDurable && !IsRobotChange(change)) {
      const auto* object = tip->objects().Find(NameOf(change));
      if (object != nullptr) models.push_back((*object)->geometry);
    }
  }
  return services.journal->KeepGeometry(models, durability);
}

absl::Status World::State::CheckObjectCount(const collision::WorldSnapshot& base,
                                            const collision::WorldSnapshot& next) const {
  const auto count = static_cast<std::int64_t>(next.objects().size());
  if (count <= services.max_objects || next.objects().size() <= base.objects().size()) {
    return absl::OkStatus();
  }
  return MakeError(absl::StatusCode::kResourceExhausted,
                   absl::StrCat("changes: the world \"", name, "\" would have ", count,
                                " objects, must have at most ", services.max_objects),
                   {.reason = "TOO_MANY_OBJECTS",
                    .metadata = {{"limit", std::to_string(services.max_objects)}}});
}

absl::StatusOr<World::State::Applied> World::State::ApplyTo(const SnapshotPtr& base,
                                                            std::span<const Change> given,
                                                            WorkBudget* budget) const {
  std::vector<Change> changes(given.begin(), given.end());
  if (absl::Status charged = ChargeGeometry(*base, changes); !charged.ok()) return charged;
  absl::StatusOr<SnapshotPtr> next = collision::Apply(base, changes, budget);
  if (HasEnded(budget)) return budget->status();
  if (!next.ok()) return ExplainRefusal(next.status(), *base, changes, "changes");
  return Applied{
      .base = base,
      .next = *next,
      .deltas = collision::Difference(*base, **next),
      .robot_deltas = collision::RobotDifference(*base, **next),
      .rule_deltas = collision::RuleDifference(base->pair_rules(), (*next)->pair_rules())};
}

absl::Status World::State::WithRoom(const std::function<absl::Status()>& write) {
  absl::Status status = write();
  if (IsShortOfMemory(status)) {
    feed->DropHistory();
    views.Clear();
    status = write();
  }
  if (IsShortOfMemory(status) && services.drop_histories && MayFit(status, *memory)) {
    services.drop_histories();
    status = write();
  }
  return status;
}

PendingWritePtr World::State::Decide(const MakeApplied& make, const WriteOptions& options,
                                     const WriteHooks& hooks) {
  auto write = std::make_shared<PendingWrite>();
  write->outcome = [&]() -> absl::StatusOr<WriteOutcome> {
    absl::StatusOr<std::optional<WriteOutcome>> decided = Precheck(options);
    if (!decided.ok()) return decided.status();
    if (decided->has_value()) return **std::move(decided);
    const auto pending = static_cast<std::int64_t>(pipeline->size());
    if (!hooks.may_use_reserve && pending >= services.max_pending_writes) {
      return TooManyPending(services.max_pending_writes);
    }
    absl::StatusOr<Applied> applied = make(pipeline->Tip());
    if (!applied.ok()) return applied.status();
    if (absl::Status few = CheckObjectCount(*applied->base, *applied->next); !few.ok()) {
      return few;
    }
    return Accept(*std::move(applied), options, hooks, *write);
  }();
  return write;
}

WriteOutcome World::State::Accept(Applied applied, const WriteOptions& options,
                                  const WriteHooks& hooks, PendingWrite& write) {
  const SnapshotPtr& next = applied.next;
  WriteOutcome outcome{.revision = next->revision(), .replayed = false, .snapshot = next};
  const bool remember = !options.request_id.empty();
  // May run out of memory, so it runs before anything of the write is stored.
  auto reply = remember && hooks.reply ? hooks.reply(outcome) : nullptr;
  WorldWrite what;
  if (hooks.facts) what.facts = hooks.facts(*next);
  if (remember) what.request = {options.request_id, options.request_digest, reply != nullptr};
  if (next != applied.base) {
    what.event = std::make_shared<const Event>(Event{next->revision(),
                                                     now(),
                                                     {applied.deltas.begin(), applied.deltas.end()},
                                                     std::move(applied.robot_deltas),
                                                     std::move(applied.rule_deltas)});
    write.next = next;
  }
  write.has_entry = what.event != nullptr || remember || !what.facts.empty() || !has_entries;
  if (!write.has_entry) return outcome;
  if (remember) requests.Insert(options, outcome, std::move(reply), now());
  if (what.facts.sensor_pose.has_value()) {
    const std::lock_guard lock(sensors_mutex);
    sensor_poses[what.facts.sensor_pose->sensor] = what.facts.sensor_pose->pose;
  }
  for (const std::string& stem : unsaved_stems) {
    what.last_numbers.emplace_back(stem, last_number[stem]);
  }
  unsaved_stems.clear();
  SetEntry(write, next->revision(), std::move(what), hooks.durability, hooks.may_use_reserve);
  return outcome;
}

void World::State::SetEntry(PendingWrite& write, Revision revision,
                            std::variant<WorldWrite, WorldDeletion> what, Durability durability,
                            bool may_use_reserve) {
  write.has_entry = true;
  if (!has_entries) write.entry.created_name = name;
  write.entry.what = std::move(what);
  has_entries = true;
  if (services.journal == nullptr) return;
  write.entry.world_uid = uid;
  write.entry.revision = revision;
  write.entry.when = std::chrono::system_clock::now();
  write.entry.durability = durability;
  write.entry.may_use_reserve = may_use_reserve;
}

WorldFeed::PostCommit World::State::Publish(const PendingWrite& write) {
  if (const auto* deletion = std::get_if<WorldDeletion>(&write.entry.what)) {
    WorldFeed::PostCommit post_commit = feed->End(EndReason::kDeleted);
    if (services.deleted) services.deleted(*world, *deletion);
    return post_commit;
  }
  const WorldWrite& what = std::get<WorldWrite>(write.entry.what);
  WorldFeed::PostCommit post_commit;
  const SnapshotPtr next = write.next != nullptr ? write.next : feed->Latest();
  if (what.event != nullptr) {
    for (const collision::ObjectDelta& delta : what.event->deltas) {
      if (delta.after == nullptr) observations.Forget(delta.before->name);
    }
    for (const collision::RobotDelta& delta : what.event->robot_deltas) {
      if (delta.after == nullptr) robot_states.Forget(delta.before->name);
    }
  }
  observations.Record(what.facts.sightings, what.facts.seen_at, *next);
  if (what.facts.sensor_pose.has_value()) {
    const std::lock_guard lock(sensors_mutex);
    journaled_poses[what.facts.sensor_pose->sensor] = what.facts.sensor_pose->pose;
  }
  if (what.event != nullptr) {
    post_commit = feed->Publish(next, what.event);
    if (!what.event->rule_deltas.empty()) ScheduleExpiry();
  }
  if (write.entry.created_name.has_value() && services.created) services.created(*world);
  return post_commit;
}

void World::State::RollBack(const std::deque<PendingWritePtr>& lost) {
  for (auto write = lost.rbegin(); write != lost.rend(); ++write) {
    if (!(*write)->has_entry) continue;
    if ((*write)->entry.created_name.has_value()) has_entries = false;
    if (const auto* what = std::get_if<WorldWrite>(&(*write)->entry.what)) {
      if (what->request.has_value()) requests.TakeBack(what->request->id);
      for (const auto& [stem, number] : what->last_numbers) unsaved_stems.insert(stem);
    } else {
      is_closed = false;
    }
  }
  const std::lock_guard lock(sensors_mutex);
  sensor_poses = journaled_poses;
}

CommitPipeline::AfterTurn World::State::Push(PendingWritePtr write, WriteDone done) {
  write->done = std::move(done);
  return pipeline->Push(std::move(write), world->weak_from_this().lock());
}

absl::Status World::State::Write(const MakeApplied& make, const WriteOptions& options,
                                 const WriteHooks& hooks, WriteDone& done) {
  CommitPipeline::AfterTurn after;
  {
    const std::lock_guard lock(turn);
    PendingWritePtr write = Decide(make, options, hooks);
    if (IsShortOfMemory(write->outcome.status())) return write->outcome.status();
    after = Push(std::move(write), std::move(done));
  }
  after.Finish();
  return absl::OkStatus();
}

}  // namespace cwm::server
