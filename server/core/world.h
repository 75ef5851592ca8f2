// One world: its snapshots, its writer's turn, its events. Readers take a snapshot (one pointer)
// and never wait for a writer's work; writers take turns; a change is published completely or not
// at all.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "server/core/journal.h"
#include "server/core/kept_scans.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/observations.h"
#include "server/core/watch.h"
#include "server/core/work_budget.h"
#include "server/core/world_image.h"
#include "server/core/write_facts.h"

namespace cwm::server {

struct IngestOutcome;  // ingest.h
class KeptViews;       // kept_views.h
class RobotStates;     // live/robot_states.h

// The revision that a query is about.
struct Latest {};
struct AtLeast {
  collision::Revision revision;
};
struct Exactly {
  collision::Revision revision;
};
using RevisionRule = std::variant<Latest, AtLeast, Exactly>;

struct WriteOptions {
  std::optional<collision::Revision> expected_revision = {};  // else Aborted REVISION_MISMATCH
  std::string request_id = {};      // empty: no protection against retries
  std::string request_digest = {};  // of the request's content, compared for a retry
};

struct WriteOutcome {
  collision::Revision revision;  // of the world after the write, with or without effect
  bool replayed = false;         // a retry: this is the first reply
  SnapshotPtr snapshot = {};     // the world at `revision`; nullptr when replayed
  std::shared_ptr<const IngestOutcome> ingest = {};  // the first reply of a replayed ingest
};

// Called once with the answer to a write.
using WriteDone = std::function<void(absl::StatusOr<WriteOutcome> outcome)>;

// Hooks of a write. Both run under the writer's turn, when the changes are known to be valid and
// before anybody sees the resulting world; they may be empty.
struct WriteHooks {
  // The facts that belong to the write but not to a revision; they become visible with it.
  std::function<WriteFacts(const collision::WorldSnapshot& next)> facts = {};
  // Makes the reply that retries of the same request_id get as `ingest`.
  std::function<std::shared_ptr<const IngestOutcome>(const WriteOutcome&)> reply = {};
  Durability durability = Durability::kDurable;
  bool may_use_reserve = false;  // as in JournalEntry
};

class RuleExpiry;  // rule_expiry.h
class World;

// Services that a world shares with others.
struct WorldServices {
  std::shared_ptr<RuleExpiry> expiry =
      {};  // ends allowances whose time is over; null: only ExpireRules does
  std::shared_ptr<MemoryBudget> memory = {};  // null: no limit
  std::function<void()> drop_histories = {};  // of all worlds, called if memory is short
  std::int64_t max_objects = Limits().max_objects;
  std::int64_t max_pending_writes = Limits().max_pending_writes;
  Journal* journal = nullptr;  // outlives the world; null: what is written ends with the process
  // Called when the first write of a new world is published, and when its end is, before the
  // answers to them. Under the turn without a journal.
  std::function<void(const World& world)> created = {};
  std::function<void(const World& world, const WorldDeletion& deletion)> deleted = {};
};

class World : public std::enable_shared_from_this<World> {
 public:
  // `now` measures ages; tests pass their own. Allowances expire by themselves only in a world that
  // a shared pointer holds.
  // A world with a journal must be held by a shared pointer.
  World(std::string name, std::string uid, Retention retention,
        std::function<Clock::time_point()> now = Clock::now, WorldServices services = {});
  // A world as it was before a restart.
  World(WorldImage image, Retention retention, std::function<Clock::time_point()> now,
        WorldServices services);
  ~World();

  const std::string& name() const;
  const std::string& uid() const;

  // The latest revision that the journal has. Never blocks on a writer's work.
  SnapshotPtr Snapshot() const;
  // AtLeast waits for the revision until `deadline` (DeadlineExceeded), `stop` (Cancelled) or the
  // world's end (NotFound WORLD_DELETED). Exactly returns OutOfRange REVISION_COMPACTED for a
  // revision that is no longer kept and REVISION_IN_FUTURE for one that was not made yet.
  absl::StatusOr<SnapshotPtr> At(const RevisionRule& rule, Clock::time_point deadline,
                                 std::stop_token stop) const;

  // Applies the changes to the newest state, all or none, and answers through `done` when the
  // journal has the write: at once without a journal, else from the journal's thread. `done` is not
  // called if the function throws. NotFound OBJECT_UNKNOWN or
  // ROBOT_UNKNOWN, ResourceExhausted TOO_MANY_PAIR_RULES, TOO_MANY_OBJECTS or MEMORY_EXHAUSTED,
  // Aborted REVISION_MISMATCH or OBJECT_REVISION_MISMATCH (expected_revision, actual_revision in
  // the metadata), FailedPrecondition REQUEST_ID_REUSED, InvalidArgument INVALID_FIELD
  // ("changes[i]"). QUEUE_FULL for too many writes that wait for the journal; DISK_FULL if the
  // journal cannot store the write, of which nothing is done then. The budget's status if it ended
  // before the list was applied.
  void StartApply(std::span<const collision::Change> changes, const WriteOptions& options,
                  WorkBudget* budget, WriteDone done);
  // Waits for the answer.
  absl::StatusOr<WriteOutcome> Apply(std::span<const collision::Change> changes,
                                     const WriteOptions& options, WorkBudget* budget = nullptr);

  // For changes that depend on the newest state (ingest): takes the writer's turn, calls `make`
  // with the state and applies the changes that it returns. `make` runs under the turn and must
  // be short; it is not called for a replay or a revision mismatch, and again if the first changes
  // found no memory. Answers as StartApply does.
  using MakeChanges =
      std::function<absl::StatusOr<std::vector<collision::Change>>(const SnapshotPtr&)>;
  void StartUpdate(const MakeChanges& make, const WriteOptions& options, const WriteHooks& hooks,
                   WriteDone done);
  // Waits for the answer.
  absl::StatusOr<WriteOutcome> Update(const MakeChanges& make, const WriteOptions& options,
                                      const WriteHooks& hooks = {});

  // Publishes the end of the allowances that expired until `now`, if there are any. Queries that
  // hold an older snapshot are answered by that snapshot. Does nothing in a world that was closed.
  // The errors of Apply.
  absl::Status ExpireRules(Clock::time_point now);
  // Sets the time of the next expiry; for a world that was restored with rules.
  void ScheduleExpiry();

  // Decides a write before its work: an error, or the first reply of a retry, is answered through
  // `done`, as by StartApply. False, with nothing called, to go on. Saves the work of a write that
  // cannot succeed.
  bool StartPrecheck(const WriteOptions& options, WriteDone done);
  // Waits for the answer; empty to go on.
  absl::StatusOr<std::optional<WriteOutcome>> Precheck(const WriteOptions& options);

  // The newest state, which the journal may not have yet: what a write is decided on. Readers must
  // not see it.
  SnapshotPtr Tip() const;
  // Stores large geometry that a later Update puts, so that the turn need not wait for the disk
  // (Journal::KeepGeometry). Does nothing without a journal. ResourceExhausted DISK_FULL.
  absl::Status KeepGeometry(std::span<const PreparedModelPtr> models, Durability durability);

  // The next name "<stem>_<n>" that no object and no robot of this world has, e.g. object_7; each
  // is returned only once. Call only under the writer's turn (in `make`).
  std::string ReserveName(const std::string& stem);

  // The kept pose of a sensor: the newest that a write's facts told, though the journal may not
  // have the write yet.
  std::optional<SensorPose> SensorPoseOf(const std::string& sensor) const;
  // Keeps a pose, by a write without changes. The errors of Update.
  absl::Status SetSensorPose(const std::string& sensor, const SensorPose& pose);

  // Scan reports about the objects; an entry is dropped with its object.
  Observations& observations();
  const Observations& observations() const;

  // The newest scan of each sensor.
  KeptScans& scans();

  // The views that scans of this world showed, for scans that show the same again.
  KeptViews& views();

  // The stamped states of robots that move; those of a robot are dropped with it.
  RobotStates& robot_states();

  // Starts a watch; see watch.h. OutOfRange REVISION_COMPACTED / REVISION_IN_FUTURE, NotFound
  // WORLD_DELETED, Unavailable SERVER_DRAINING.
  absl::StatusOr<std::unique_ptr<WatchCursor>> Watch(const WatchOptions& options,
                                                     std::function<void()> wake);

  // Calls `wake` after every later publication and at the world's end, until the result is
  // released; perhaps once more after that. Called by writers: it must be short.
  std::shared_ptr<const void> WakeOnPublication(std::function<void()> wake) const;

  // True once the journal has the world's deletion.
  bool is_deleted() const;
  // The oldest revision that is kept without a lease.
  collision::Revision oldest_exact() const;
  collision::Revision oldest_watch() const;

  // Drops all revisions but the latest, and the kept views, to free their memory.
  void DropHistory();
  // Bytes charged to this world.
  std::int64_t memory_bytes() const;

  // Refuses writes with NotFound WORLD_DELETED and, when the journal has the deletion, ends all
  // watches. Snapshots that readers hold stay valid. Waits; returns the world's last revision.
  // NotFound WORLD_DELETED if it was closed before; DISK_FULL, then the world stays.
  absl::StatusOr<collision::Revision> Close(const WorldDeletion& deletion = {});
  // Ends all watches with a last bookmark, for shutting down. Writes in progress still finish.
  void Drain();

 private:
  struct State;

  // OK if the write was decided; MEMORY_EXHAUSTED if it may succeed with more room.
  absl::Status ApplyOnce(std::span<const collision::Change> changes, const WriteOptions& options,
                         const WriteHooks& hooks, WorkBudget* budget, WriteDone& done);

  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
