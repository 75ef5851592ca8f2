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
#include "server/core/kept_scans.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/observations.h"
#include "server/core/watch.h"
#include "server/core/work_budget.h"
#include "server/core/write_facts.h"

namespace cwm::server {

struct IngestOutcome;  // ingest.h

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

// Hooks of a write. Both run under the writer's turn and may be empty.
struct WriteHooks {
  // Called when the changes are known to be valid, before anybody sees the resulting world: for
  // data that belongs to the write but not to a revision.
  std::function<void(const collision::WorldSnapshot& next)> applied = {};
  // Called before that: makes the reply that retries of the same request_id get as `ingest`.
  std::function<std::shared_ptr<const IngestOutcome>(const WriteOutcome&)> reply = {};
};

// Adds reason and details to a status of collision::Apply, as documented at World::Apply; `list` is
// the request's field that held the changes.
absl::Status ExplainRefusal(const absl::Status& status, const collision::WorldSnapshot& base,
                            std::span<const collision::Change> changes, const std::string& list);

class RuleExpiry;  // rule_expiry.h

// Services that a world shares with others.
struct WorldServices {
  std::shared_ptr<RuleExpiry> expiry =
      {};  // ends allowances whose time is over; null: only ExpireRules does
  std::shared_ptr<MemoryBudget> memory = {};  // null: no limit
  std::function<void()> drop_histories = {};  // of all worlds, called if memory is short
  std::int64_t max_objects = Limits().max_objects;
};

class World : public std::enable_shared_from_this<World> {
 public:
  // `now` measures ages; tests pass their own. Allowances expire by themselves only in a world that
  // a shared pointer holds.
  World(std::string name, std::string uid, Retention retention,
        std::function<Clock::time_point()> now = Clock::now, WorldServices services = {});
  ~World();

  const std::string& name() const;
  const std::string& uid() const;

  // Never blocks on a writer's work.
  SnapshotPtr Snapshot() const;
  // AtLeast waits for the revision until `deadline` (DeadlineExceeded), `stop` (Cancelled) or the
  // world's end (NotFound WORLD_DELETED). Exactly returns OutOfRange REVISION_COMPACTED for a
  // revision that is no longer kept and REVISION_IN_FUTURE for one that was not made yet.
  absl::StatusOr<SnapshotPtr> At(const RevisionRule& rule, Clock::time_point deadline,
                                 std::stop_token stop) const;

  // Applies the changes to the latest snapshot, all or none. NotFound OBJECT_UNKNOWN or
  // ROBOT_UNKNOWN, ResourceExhausted TOO_MANY_PAIR_RULES, TOO_MANY_OBJECTS or MEMORY_EXHAUSTED,
  // Aborted REVISION_MISMATCH or OBJECT_REVISION_MISMATCH (expected_revision, actual_revision in
  // the metadata), FailedPrecondition REQUEST_ID_REUSED, InvalidArgument INVALID_FIELD
  // ("changes[i]"). The budget's status if it ended before the list was applied.
  absl::StatusOr<WriteOutcome> Apply(std::span<const collision::Change> changes,
                                     const WriteOptions& options, WorkBudget* budget = nullptr);

  // For changes that depend on the latest snapshot (ingest): takes the writer's turn, calls `make`
  // with the snapshot and applies the changes that it returns. `make` runs under the turn and must
  // be short; it is not called for a replay or a revision mismatch.
  using MakeChanges =
      std::function<absl::StatusOr<std::vector<collision::Change>>(const SnapshotPtr&)>;
  absl::StatusOr<WriteOutcome> Update(const MakeChanges& make, const WriteOptions& options,
                                      const WriteHooks& hooks = {});

  // Publishes the end of the allowances that expired until `now`, if there are any. Queries that
  // hold an older snapshot are answered by that snapshot. Does nothing in a world that was closed.
  void ExpireRules(Clock::time_point now);

  // The result of Update before it would call `make`: an error, the first reply of a retry, or
  // empty to go on. Saves the work of a write that cannot succeed.
  absl::StatusOr<std::optional<WriteOutcome>> Precheck(const WriteOptions& options) const;

  // The next name "<stem>_<n>" that no object and no robot of this world has, e.g. object_7; each
  // is returned only once. Call only under the writer's turn (in `make`).
  std::string ReserveName(const std::string& stem);

  // The kept pose of a sensor. Its first estimated pose is kept until a pose is given or an up
  // direction contradicts it. SetSensorPose replaces it.
  std::optional<SensorPose> SensorPoseOf(const std::string& sensor) const;
  void SetSensorPose(const std::string& sensor, const SensorPose& pose);

  // Scan reports about the objects; an entry is dropped with its object.
  Observations& observations();
  const Observations& observations() const;

  // The newest scan of each sensor.
  KeptScans& scans();

  // Starts a watch; see watch.h. OutOfRange REVISION_COMPACTED / REVISION_IN_FUTURE, NotFound
  // WORLD_DELETED, Unavailable SERVER_DRAINING.
  absl::StatusOr<std::unique_ptr<WatchCursor>> Watch(const WatchOptions& options,
                                                     std::function<void()> wake);

  collision::Revision oldest_exact() const;
  collision::Revision oldest_watch() const;

  // Drops all revisions but the latest, to free their memory.
  void DropHistory();
  // Bytes charged to this world.
  std::int64_t memory_bytes() const;

  // Ends all watches and refuses writes with NotFound WORLD_DELETED. Snapshots that readers hold
  // stay valid.
  void Close();
  // Ends all watches with a last bookmark, for shutting down. Writes in progress still finish.
  void Drain();

 private:
  struct State;

  // A long list is applied to the latest snapshot before the turn is taken, so that other writes
  // can pass it. The result is published if the snapshot is still the latest; otherwise the list is
  // applied again.
  absl::StatusOr<WriteOutcome> ApplyOnce(std::span<const collision::Change> changes,
                                         const WriteOptions& options, WorkBudget* budget);

  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
