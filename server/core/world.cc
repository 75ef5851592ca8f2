#include "server/core/world.h"

#include <algorithm>
#include <future>
#include <mutex>
#include <set>
#include <unordered_map>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/world_state.h"

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

bool IsExpiry(const Change& change) {
  return std::holds_alternative<collision::ExpireRules>(change.what);
}

// True for what is told again and again, so that a power cut may take it.
bool IsObserved(const Change& change) {
  return std::holds_alternative<collision::SetRobotState>(change.what) || IsExpiry(change);
}

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

constexpr std::int64_t kUnlimitedBytes = std::int64_t{1} << 60;

// The answer of a write to somebody who waits for it.
class AwaitedAnswer {
 public:
  WriteDone Receiver() {
    return [this](absl::StatusOr<WriteOutcome> outcome) { promise_.set_value(std::move(outcome)); };
  }
  absl::StatusOr<WriteOutcome> Wait() { return promise_.get_future().get(); }

 private:
  std::promise<absl::StatusOr<WriteOutcome>> promise_;
};

}  // namespace

World::World(std::string name, std::string uid, Retention retention,
             std::function<Clock::time_point()> now, WorldServices services)
    : World(WorldImage{.name = std::move(name),
                       .uid = std::move(uid),
                       .base = std::make_shared<const collision::WorldSnapshot>()},
            retention, std::move(now), std::move(services)) {
  state_->has_entries = false;
}

World::World(WorldImage image, Retention retention, std::function<Clock::time_point()> now,
             WorldServices services) {
  const std::shared_ptr<MemoryBudget> memory =
      services.memory != nullptr ? services.memory : MemoryBudget::Make(kUnlimitedBytes);
  const auto payer =
      image.payer.value_or(MemoryBudget::World(memory->NextWorldNumber(), image.name));
  Journal* const journal = services.journal;
  state_.reset(
      new State{.name = std::move(image.name),
                .uid = std::move(image.uid),
                .now = now,
                .services = std::move(services),
                .memory = memory,
                .payer = payer,
                .feed = std::make_shared<WorldFeed>(
                    retention, now, MemoryCharge::Empty(memory, payer), std::move(image.base)),
                .turn = {},
                .requests = IdempotencyCache(retention, MemoryCharge::Empty(memory, payer)),
                .last_number = {image.last_numbers.begin(), image.last_numbers.end()},
                .has_entries = true,
                .sensors_mutex = {},
                .sensor_poses = {image.sensor_poses.begin(), image.sensor_poses.end()},
                .journaled_poses = {image.sensor_poses.begin(), image.sensor_poses.end()},
                .expiry_mutex = {},
                .observations = {},
                .scans = {},
                .views = KeptViews(MemoryCharge::Empty(memory, payer)),
                .robot_states = {},
                .world = this});
  State& state = *state_;
  state.pipeline.emplace(
      journal, state.turn, [&state] { return state.feed->Latest(); },
      CommitPipeline::Owner{
          .publish = [&state](const PendingWrite& write) { return state.Publish(write); },
          .roll_back =
              [&state](const std::deque<PendingWritePtr>& lost) { state.RollBack(lost); }});
  state.feed->RestoreEvents(image.earlier, image.oldest_watch);
  for (WorldImage::Step& step : image.steps) {
    state.feed->Publish(std::move(step.next), std::move(step.event)).Finish();
  }
  for (const WorldImage::Request& request : image.requests) state.requests.Restore(request);
  for (const WorldImage::Observed& each : image.observations) {
    state.observations.Restore(each.name, each.observation);
  }
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

SnapshotPtr World::Tip() const { return state_->pipeline->Tip(); }

void World::StartApply(std::span<const Change> changes, const WriteOptions& options,
                       WorkBudget* budget, WriteDone done) {
  const bool is_observed = std::ranges::all_of(changes, IsObserved);
  const WriteHooks hooks{
      .durability = is_observed ? Durability::kObserved : Durability::kDurable,
      .may_use_reserve = !changes.empty() && std::ranges::all_of(changes, IsExpiry)};
  absl::Status written = state_->KeepGeometryOf(changes, hooks.durability);
  if (written.ok()) {
    written = state_->WithRoom([&] { return ApplyOnce(changes, options, hooks, budget, done); });
  }
  if (!written.ok()) done(written);
}

// A long list is applied to the newest state before the turn is taken, so that other writes can
// pass it. The result counts if the state is still the newest; otherwise the list is applied again.
absl::Status World::ApplyOnce(std::span<const Change> changes, const WriteOptions& options,
                              const WriteHooks& hooks, WorkBudget* budget, WriteDone& done) {
  absl::StatusOr<State::Applied> ahead = State::Applied{};
  const auto make = [&](const SnapshotPtr& base) {
    const bool is_ahead = ahead.ok() && ahead->base == base;
    return is_ahead ? std::move(ahead) : state_->ApplyTo(base, changes, budget);
  };
  const bool is_long = IsLong(changes, *Snapshot());
  for (int attempt = 0; is_long && attempt < kMaxAttemptsAhead; ++attempt) {
    const SnapshotPtr base = Tip();
    ahead = State::Applied{};  // gives the previous attempt's charge back first
    ahead = state_->ApplyTo(base, changes, budget);
    if (HasEnded(budget)) return budget->status();
    if (Tip() == base) break;
  }
  return state_->Write(make, options, hooks, done);
}

absl::StatusOr<WriteOutcome> World::Apply(std::span<const Change> changes,
                                          const WriteOptions& options, WorkBudget* budget) {
  AwaitedAnswer answer;
  StartApply(changes, options, budget, answer.Receiver());
  return answer.Wait();
}

void World::StartUpdate(const MakeChanges& make, const WriteOptions& options,
                        const WriteHooks& hooks, WriteDone done) {
  const auto apply = [&](const SnapshotPtr& base) -> absl::StatusOr<State::Applied> {
    const absl::StatusOr<std::vector<Change>> changes = make(base);
    if (!changes.ok()) return changes.status();
    return state_->ApplyTo(base, *changes, nullptr);
  };
  const absl::Status written =
      state_->WithRoom([&] { return state_->Write(apply, options, hooks, done); });
  if (!written.ok()) done(written);
}

absl::StatusOr<WriteOutcome> World::Update(const MakeChanges& make, const WriteOptions& options,
                                           const WriteHooks& hooks) {
  AwaitedAnswer answer;
  StartUpdate(make, options, hooks, answer.Receiver());
  return answer.Wait();
}

absl::Status World::KeepGeometry(std::span<const PreparedModelPtr> models, Durability durability) {
  Journal* const journal = state_->services.journal;
  return journal == nullptr ? absl::OkStatus() : journal->KeepGeometry(models, durability);
}

void World::DropHistory() {
  state_->feed->DropHistory();
  state_->views.Clear();
}

std::int64_t World::memory_bytes() const { return state_->memory->world_bytes_of(state_->payer); }

absl::Status World::ExpireRules(Clock::time_point now) {
  const Change expire{.what = collision::ExpireRules{now}, .expected_object_revision = {}};
  const absl::Status expired = Apply({&expire, 1}, {}).status();
  if (absl::IsNotFound(expired)) return absl::OkStatus();  // the world was closed
  // Nothing was published if nothing had expired yet; then there is a next time.
  if (expired.ok()) ScheduleExpiry();
  return expired;
}

void World::ScheduleExpiry() { state_->ScheduleExpiry(); }

bool World::StartPrecheck(const WriteOptions& options, WriteDone done) {
  CommitPipeline::AfterTurn after;
  {
    const std::lock_guard turn(state_->turn);
    absl::StatusOr<std::optional<WriteOutcome>> decided = state_->Precheck(options);
    if (decided.ok() && !decided->has_value()) return false;
    auto write = std::make_shared<PendingWrite>();
    write->outcome =
        decided.ok() ? absl::StatusOr<WriteOutcome>(**std::move(decided)) : decided.status();
    after = state_->Push(std::move(write), std::move(done));
  }
  after.Finish();
  return true;
}

absl::StatusOr<std::optional<WriteOutcome>> World::Precheck(const WriteOptions& options) {
  AwaitedAnswer answer;
  if (!StartPrecheck(options, answer.Receiver())) return std::nullopt;
  absl::StatusOr<WriteOutcome> outcome = answer.Wait();
  if (!outcome.ok()) return outcome.status();
  return std::optional(*std::move(outcome));
}

std::string World::ReserveName(const std::string& stem) {
  const SnapshotPtr tip = Tip();
  std::int64_t& number = state_->last_number[stem];
  state_->unsaved_stems.insert(stem);
  std::string name;
  do {  // a user may have taken some of these names
    name = absl::StrCat(stem, "_", ++number);
  } while (tip->Find(name) != nullptr || tip->FindRobot(name) != nullptr);
  return name;
}

std::optional<SensorPose> World::SensorPoseOf(const std::string& sensor) const {
  std::lock_guard lock(state_->sensors_mutex);
  const auto found = state_->sensor_poses.find(sensor);
  if (found == state_->sensor_poses.end()) return std::nullopt;
  return found->second;
}

absl::Status World::SetSensorPose(const std::string& sensor, const SensorPose& pose) {
  const auto nothing = [](const SnapshotPtr&) { return std::vector<Change>(); };
  const auto facts = [&](const collision::WorldSnapshot&) {
    return WriteFacts{.sensor_pose = NamedSensorPose{sensor, pose}};
  };
  return Update(nothing, {}, {.facts = facts}).status();
}

Observations& World::observations() { return state_->observations; }
const Observations& World::observations() const { return state_->observations; }

KeptScans& World::scans() { return state_->scans; }

KeptViews& World::views() { return state_->views; }

RobotStates& World::robot_states() { return state_->robot_states; }

bool World::is_deleted() const { return state_->feed->end_reason() == EndReason::kDeleted; }

absl::StatusOr<std::unique_ptr<WatchCursor>> World::Watch(const WatchOptions& options,
                                                          std::function<void()> wake) {
  return StartWatch(state_->feed, options, std::move(wake));
}

std::shared_ptr<const void> World::WakeOnPublication(std::function<void()> wake) const {
  const auto subscription = state_->feed->Subscribe(std::move(wake));
  return {subscription.get(),
          [feed = state_->feed, subscription](const void*) { feed->Unsubscribe(subscription); }};
}

Revision World::oldest_exact() const { return state_->feed->oldest_exact(); }
Revision World::oldest_watch() const { return state_->feed->oldest_watch(); }

absl::StatusOr<Revision> World::Close(const WorldDeletion& deletion) {
  AwaitedAnswer answer;
  CommitPipeline::AfterTurn after;
  {
    const std::lock_guard turn(state_->turn);
    auto write = std::make_shared<PendingWrite>();
    if (state_->is_closed) {
      write->outcome = WorldDeleted();
    } else {
      const Revision last = Tip()->revision();
      write->outcome = WriteOutcome{.revision = last};
      state_->SetEntry(*write, last, deletion, Durability::kDurable,
                       /*may_use_reserve=*/true);
      state_->is_closed = true;
    }
    after = state_->Push(std::move(write), answer.Receiver());
  }
  after.Finish();
  const absl::StatusOr<WriteOutcome> closed = answer.Wait();
  if (!closed.ok()) return closed.status();
  return closed->revision;
}

void World::Drain() { state_->feed->End(EndReason::kDraining).Finish(); }

}  // namespace cwm::server
