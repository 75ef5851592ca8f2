#include "server/core/world.h"

#include <algorithm>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/idempotency_cache.h"
#include "server/core/rule_expiry.h"
#include "server/core/world_feed.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;

// chosen: the number of changes, and of parts of the objects that they place, that are applied
// within the writer's turn; so many take about a millisecond.
constexpr std::size_t kMaxWeightWithinTurn = 256;
// chosen: how often a long list is applied outside the turn and found out of date while others
// write all the time; the last attempt is completed within the turn.
constexpr int kMaxAttemptsAhead = 3;

// True if the changes take long to apply. An estimate: objects that the list itself makes do not
// count.
bool IsLong(std::span<const Change> changes, const collision::WorldSnapshot& latest) {
  std::size_t weight = changes.size();
  for (const Change& change : changes) {
    if (weight > kMaxWeightWithinTurn) return true;
    if (const auto* put = std::get_if<collision::PutObject>(&change.what)) {
      weight += put->geometry != nullptr ? put->geometry->parts.size() : 0;
    } else if (!IsPairRuleChange(change) && !IsRobotChange(change)) {
      const auto* object = latest.objects().Find(NameOf(change));
      weight += object != nullptr ? (*object)->parts_W.size() : 0;
    }
  }
  return weight > kMaxWeightWithinTurn;
}

// The path of the field at fault in the request that holds the list.
std::string FieldOf(const Change& change, const collision::ApplyFault& fault,
                    const std::string& list) {
  std::string place = absl::StrCat(list, "[", fault.change, "]");
  if (fault.field != "expected_object_revision") {
    if (std::holds_alternative<collision::SetRobotState>(change.what)) place += ".robot_state";
    if (std::holds_alternative<collision::AttachObject>(change.what)) place += ".attach";
    if (std::holds_alternative<collision::AllowCollision>(change.what)) place += ".allow";
    if (std::holds_alternative<collision::SetPairMargin>(change.what)) place += ".margin";
  }
  return fault.field.empty() ? place : absl::StrCat(place, ".", fault.field);
}

constexpr std::int64_t kUnlimitedBytes = std::int64_t{1} << 60;

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

absl::Status RevisionMismatch(Revision expected, Revision actual) {
  return MakeError(
      absl::StatusCode::kAborted,
      absl::StrCat("expected_revision: is ", expected.value, ", the world is at ", actual.value),
      {.reason = "REVISION_MISMATCH",
       .metadata = {{"expected_revision", std::to_string(expected.value)},
                    {"actual_revision", std::to_string(actual.value)}}});
}

}  // namespace

absl::Status ExplainRefusal(const absl::Status& status, const collision::WorldSnapshot& base,
                            std::span<const Change> changes, const std::string& list) {
  const std::optional<collision::ApplyFault> fault = collision::FaultOf(status);
  const Change* change = fault.has_value() ? &changes[fault->change] : nullptr;
  const bool is_of_robot = change != nullptr && IsRobotChange(*change);
  ErrorDetails details;
  if (change != nullptr) {
    details.metadata["change_index"] = std::to_string(fault->change);
    if (!IsPairRuleChange(*change)) {
      details.metadata[is_of_robot ? "robot" : "object"] = NameOf(*change);
    }
    if (const auto* attach = std::get_if<collision::AttachObject>(&change->what)) {
      details.metadata["robot"] = attach->robot;
    }
  }
  if (status.code() == absl::StatusCode::kNotFound) {
    const bool no_robot = change != nullptr && IsUnknownRobotFault(*change, *fault);
    details.reason = no_robot ? "ROBOT_UNKNOWN" : "OBJECT_UNKNOWN";
  } else if (status.code() == absl::StatusCode::kAborted) {
    details.reason = "OBJECT_REVISION_MISMATCH";
    if (change != nullptr && change->expected_object_revision.has_value()) {
      details.metadata["expected_revision"] =
          std::to_string(change->expected_object_revision->value);
      const std::optional<Revision> actual = LatestRevisionOf(base, *change);
      if (actual.has_value()) {  // empty: there is no such object
        details.metadata["actual_revision"] = std::to_string(actual->value);
      }
    }
  } else if (status.code() == absl::StatusCode::kResourceExhausted) {
    details.reason = "TOO_MANY_PAIR_RULES";
    details.metadata["limit"] = std::to_string(collision::kMaxPairRules);
  } else {
    details.reason = "INVALID_FIELD";
    if (fault.has_value()) details.fields.push_back({FieldOf(*change, *fault, list), fault->rule});
  }
  std::string message(status.message());
  if (fault.has_value()) {  // the message begins with an index into "changes", which the request
                            // may call differently
    message = absl::StrCat(list, message.substr(message.find('[')));
  }
  return MakeError(status.code(), std::move(message), std::move(details));
}

struct World::State {
  const std::string name;
  const std::string uid;
  const std::function<Clock::time_point()> now;
  const WorldServices services;
  const std::shared_ptr<MemoryBudget> memory;
  const MemoryBudget::Payer payer;  // this world
  const std::shared_ptr<WorldFeed> feed;

  std::mutex turn;                                            // the writers' turn
  IdempotencyCache requests;                                  // under the turn
  std::unordered_map<std::string, std::int64_t> last_number;  // of ReserveName; under the turn

  mutable std::mutex sensors_mutex;
  std::unordered_map<std::string, SensorPose> sensor_poses;

  Observations observations;
  KeptScans scans;

  // Under the turn. The checks of a write that precede its changes: an error, the first reply of a
  // retry, or empty to go on.
  absl::StatusOr<std::optional<WriteOutcome>> Precheck(const WriteOptions& options) {
    if (feed->end_reason() == EndReason::kDeleted) return WorldDeleted();
    absl::StatusOr<std::optional<WriteOutcome>> first = requests.Find(options, now());
    if (!first.ok() || first->has_value()) return first;
    const Revision latest = feed->Latest()->revision();
    if (options.expected_revision.has_value() && *options.expected_revision != latest) {
      return RevisionMismatch(*options.expected_revision, latest);
    }
    return std::nullopt;
  }

  // Under the turn, so that the last call is about the latest revision.
  void ScheduleExpiry(const collision::WorldSnapshot& latest, const std::weak_ptr<World>& self) {
    if (services.expiry == nullptr) return;
    services.expiry->Set(uid, self, collision::NextExpiry(latest.pair_rules()));
  }

  // Geometry that a change brings is charged to the world for as long as anything refers to it.
  absl::Status ChargeGeometry(const collision::WorldSnapshot& base,
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

  absl::Status CheckObjectCount(const collision::WorldSnapshot& base,
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

  // A list of changes and its effect on a snapshot. Made without a lock.
  struct Applied {
    SnapshotPtr base, next;
    std::vector<collision::ObjectDelta> deltas;
    std::vector<collision::RobotDelta> robot_deltas;
    std::vector<collision::PairRuleDelta> rule_deltas;
  };
  absl::StatusOr<Applied> ApplyTo(const SnapshotPtr& base, std::span<const Change> given,
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

  // Runs the write; if memory is short, forgets the past, first of this world, then of all, and
  // tries again.
  absl::StatusOr<WriteOutcome> WithRoom(
      const std::function<absl::StatusOr<WriteOutcome>()>& write) const {
    absl::StatusOr<WriteOutcome> outcome = write();
    if (IsShortOfMemory(outcome.status())) {
      feed->DropHistory();
      outcome = write();
    }
    if (IsShortOfMemory(outcome.status()) && services.drop_histories &&
        MayFit(outcome.status(), *memory)) {
      services.drop_histories();
      outcome = write();
    }
    return outcome;
  }

  using MakeApplied = std::function<absl::StatusOr<Applied>(const SnapshotPtr& base)>;

  // Under the turn.
  absl::StatusOr<WriteOutcome> Write(const MakeApplied& make, const WriteOptions& options,
                                     const WriteHooks& hooks, const std::weak_ptr<World>& self,
                                     WorldFeed::PostCommit& post_commit) {
    absl::StatusOr<std::optional<WriteOutcome>> decided = Precheck(options);
    if (!decided.ok()) return decided.status();
    if (decided->has_value()) return **std::move(decided);

    absl::StatusOr<Applied> applied = make(feed->Latest());
    if (!applied.ok()) return applied.status();
    const SnapshotPtr& next = applied->next;
    if (absl::Status few = CheckObjectCount(*applied->base, *next); !few.ok()) return few;
    WriteOutcome outcome{.revision = next->revision(), .replayed = false, .snapshot = next};
    // May run out of memory, so it runs before anything of the write is stored.
    const bool remember = !options.request_id.empty();
    auto reply = remember && hooks.reply ? hooks.reply(outcome) : nullptr;
    for (const collision::ObjectDelta& delta : applied->deltas) {
      if (delta.after == nullptr) observations.Forget(delta.before->name);
    }
    if (hooks.applied) hooks.applied(*next);
    if (next != applied->base) {
      const bool other_rules = !applied->rule_deltas.empty();
      post_commit =
          feed->Publish(next, std::move(applied->deltas), std::move(applied->robot_deltas),
                        std::move(applied->rule_deltas));
      if (other_rules) ScheduleExpiry(*next, self);
    }
    if (remember) requests.Insert(options, outcome, std::move(reply), now());
    return outcome;
  }
};

World::World(std::string name, std::string uid, Retention retention,
             std::function<Clock::time_point()> now, WorldServices services) {
  const std::shared_ptr<MemoryBudget> memory =
      services.memory != nullptr ? services.memory : MemoryBudget::Make(kUnlimitedBytes);
  const auto payer = MemoryBudget::World(memory->NextWorldNumber(), name);
  state_.reset(new State{
      .name = std::move(name),
      .uid = std::move(uid),
      .now = now,
      .services = std::move(services),
      .memory = memory,
      .payer = payer,
      .feed = std::make_shared<WorldFeed>(retention, now, MemoryCharge::Empty(memory, payer)),
      .turn = {},
      .requests = IdempotencyCache(retention, MemoryCharge::Empty(memory, payer)),
      .last_number = {},
      .sensors_mutex = {},
      .sensor_poses = {},
      .observations = {},
      .scans = {}});
}

World::~World() {
  const auto& expiry = state_->services.expiry;
  if (expiry != nullptr) expiry->Set(state_->uid, {}, std::nullopt);
}

const std::string& World::name() const { return state_->name; }
const std::string& World::uid() const { return state_->uid; }
SnapshotPtr World::Snapshot() const { return state_->feed->Latest(); }

absl::StatusOr<SnapshotPtr> World::At(const RevisionRule& rule, Clock::time_point deadline,
                                      std::stop_token stop) const {
  return state_->feed->At(rule, deadline, std::move(stop));
}

// A long list is applied to the latest snapshot before the turn is taken, so that other writes can
// pass it. The result is published if the snapshot is still the latest; otherwise the list is
// applied again.
absl::StatusOr<WriteOutcome> World::Apply(std::span<const Change> changes,
                                          const WriteOptions& options, WorkBudget* budget) {
  return state_->WithRoom([&] { return ApplyOnce(changes, options, budget); });
}

absl::StatusOr<WriteOutcome> World::ApplyOnce(std::span<const Change> changes,
                                              const WriteOptions& options, WorkBudget* budget) {
  absl::StatusOr<State::Applied> ahead = State::Applied{};
  const auto make = [&](const SnapshotPtr& base) {
    const bool is_ahead = ahead.ok() && ahead->base == base;
    return is_ahead ? std::move(ahead) : state_->ApplyTo(base, changes, budget);
  };
  WorldFeed::PostCommit post_commit;
  absl::StatusOr<WriteOutcome> outcome = [&] {
    const bool is_long = IsLong(changes, *Snapshot());
    for (int attempt = 0; is_long; ++attempt) {
      const SnapshotPtr base = Snapshot();
      ahead = State::Applied{};  // gives the previous attempt's charge back first
      ahead = state_->ApplyTo(base, changes, budget);
      if (HasEnded(budget)) return absl::StatusOr<WriteOutcome>(budget->status());
      const std::lock_guard turn(state_->turn);
      if (attempt + 1 < kMaxAttemptsAhead && Snapshot() != base) continue;
      return state_->Write(make, options, {}, weak_from_this(), post_commit);
    }
    const std::lock_guard turn(state_->turn);
    return state_->Write(make, options, {}, weak_from_this(), post_commit);
  }();
  post_commit.Finish();
  return outcome;
}

absl::StatusOr<WriteOutcome> World::Update(const MakeChanges& make, const WriteOptions& options,
                                           const WriteHooks& hooks) {
  const auto apply = [&](const SnapshotPtr& base) -> absl::StatusOr<State::Applied> {
    const absl::StatusOr<std::vector<Change>> changes = make(base);
    if (!changes.ok()) return changes.status();
    return state_->ApplyTo(base, *changes, nullptr);
  };
  return state_->WithRoom([&] {
    WorldFeed::PostCommit post_commit;
    absl::StatusOr<WriteOutcome> outcome = [&] {
      std::lock_guard turn(state_->turn);
      return state_->Write(apply, options, hooks, weak_from_this(), post_commit);
    }();
    post_commit.Finish();
    return outcome;
  });
}

void World::DropHistory() { state_->feed->DropHistory(); }

std::int64_t World::memory_bytes() const { return state_->memory->world_bytes_of(state_->payer); }

void World::ExpireRules(Clock::time_point now) {
  const Change expire{.what = collision::ExpireRules{now}, .expected_object_revision = {}};
  if (!Apply({&expire, 1}, {}).ok()) return;  // the world was closed, and its rules with it
  // Nothing was published if nothing had expired yet; then there is a next time.
  std::lock_guard turn(state_->turn);
  state_->ScheduleExpiry(*Snapshot(), weak_from_this());
}

absl::StatusOr<std::optional<WriteOutcome>> World::Precheck(const WriteOptions& options) const {
  std::lock_guard turn(state_->turn);
  return state_->Precheck(options);
}

std::string World::ReserveName(const std::string& stem) {
  const SnapshotPtr latest = Snapshot();
  std::int64_t& number = state_->last_number[stem];
  std::string name;
  do {  // a user may have taken some of these names
    name = absl::StrCat(stem, "_", ++number);
  } while (latest->Find(name) != nullptr || latest->FindRobot(name) != nullptr);
  return name;
}

std::optional<SensorPose> World::SensorPoseOf(const std::string& sensor) const {
  std::lock_guard lock(state_->sensors_mutex);
  const auto found = state_->sensor_poses.find(sensor);
  if (found == state_->sensor_poses.end()) return std::nullopt;
  return found->second;
}

void World::SetSensorPose(const std::string& sensor, const SensorPose& pose) {
  std::lock_guard lock(state_->sensors_mutex);
  state_->sensor_poses[sensor] = pose;
}

Observations& World::observations() { return state_->observations; }
const Observations& World::observations() const { return state_->observations; }

KeptScans& World::scans() { return state_->scans; }

absl::StatusOr<std::unique_ptr<WatchCursor>> World::Watch(const WatchOptions& options,
                                                          std::function<void()> wake) {
  return StartWatch(state_->feed, options, std::move(wake));
}

Revision World::oldest_exact() const { return state_->feed->oldest_exact(); }
Revision World::oldest_watch() const { return state_->feed->oldest_watch(); }

void World::Close() {
  WorldFeed::PostCommit post_commit;
  {
    std::lock_guard turn(state_->turn);  // so that a write in progress is published before the end
    post_commit = state_->feed->End(EndReason::kDeleted);
  }
  post_commit.Finish();
}

void World::Drain() { state_->feed->End(EndReason::kDraining).Finish(); }

}  // namespace cwm::server
