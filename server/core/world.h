// One world: its snapshots, its writer's turn, its events. Readers take a snapshot (one pointer)
// and never wait for a writer's work; writers take turns; a change is published whole or not at
// all.
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

namespace cwm::server {

struct IngestOutcome;  // ingest.h

// Which revision a question is about.
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
  std::string request_digest = {};  // of the request's content, compared on a retry
};

struct WriteOutcome {
  collision::Revision revision;  // of the world after the write (unchanged when it had no effect)
  bool replayed = false;         // a retry: this is the first reply
  SnapshotPtr snapshot = {};     // the world at `revision`; nullptr when replayed
  std::shared_ptr<const IngestOutcome> ingest = {};  // the first reply of a replayed ingest
};

// What goes with a write: both run under the writer's turn and may be empty.
struct WriteHooks {
  // Once the changes are known to be good, before anybody sees the world that they lead to: for
  // what belongs to the write and is no part of a revision.
  std::function<void(const collision::WorldSnapshot& next)> applied = {};
  // Before that: makes what retries of the same request_id get as `ingest`.
  std::function<std::shared_ptr<const IngestOutcome>(const WriteOutcome&)> reply = {};
};

// Where a sensor stands, for its scans that do not say it.
struct SensorPose {
  Pose X_WC = Pose::Identity();
  bool given = false;  // told by somebody, not estimated from a scan
};

// Gives a status of collision::Apply its reason and details, as World::Apply says; `list` is the
// field of the request that held the changes.
absl::Status ExplainRefusal(const absl::Status& status, const collision::WorldSnapshot& base,
                            std::span<const collision::Change> changes, const std::string& list);

class RuleExpiry;  // rule_expiry.h

// What a world shares with others.
struct WorldSurroundings {
  std::shared_ptr<RuleExpiry> expiry =
      {};  // ends allowances that are over; null: only ExpireRules does
  std::shared_ptr<MemoryBudget> memory = {};  // null: without a limit
  std::function<void()> forget_pasts = {};    // of all worlds, where memory is short
  std::int64_t max_objects = Limits().max_objects;
};

class World : public std::enable_shared_from_this<World> {
 public:
  // `now` tells ages; tests pass their own. Allowances end by themselves in a world that a shared
  // pointer holds.
  World(std::string name, std::string uid, Retention retention,
        std::function<Clock::time_point()> now = Clock::now, WorldSurroundings around = {});
  ~World();

  const std::string& name() const;
  const std::string& uid() const;

  // Never blocks on a writer's work.
  SnapshotPtr Snapshot() const;
  // AtLeast waits for the revision until `deadline` (DeadlineExceeded), `stop` (Cancelled) or the
  // world's end (NotFound WORLD_DELETED); Exactly answers OutOfRange REVISION_COMPACTED for one no
  // longer kept and REVISION_IN_FUTURE for one not yet made.
  absl::StatusOr<SnapshotPtr> At(const RevisionRule& rule, Clock::time_point deadline,
                                 std::stop_token stop) const;

  // Applies the changes to the latest snapshot, all or nothing. NotFound OBJECT_UNKNOWN or
  // ROBOT_UNKNOWN, ResourceExhausted TOO_MANY_PAIR_RULES, TOO_MANY_OBJECTS or MEMORY_EXHAUSTED,
  // Aborted REVISION_MISMATCH or OBJECT_REVISION_MISMATCH (expected_revision, actual_revision in
  // the metadata), FailedPrecondition REQUEST_ID_REUSED, InvalidArgument INVALID_FIELD
  // ("changes[i]"). The status of the budget where it ended before the list was applied.
  absl::StatusOr<WriteOutcome> Apply(std::span<const collision::Change> changes,
                                     const WriteOptions& options, WorkBudget* budget = nullptr);

  // For changes that are made from the latest snapshot (ingest): takes the writer's turn, calls
  // `make` with it and applies what it returns. `make` runs under the turn and must be short; it
  // is not called for a replay or a revision that does not match.
  using MakeChanges =
      std::function<absl::StatusOr<std::vector<collision::Change>>(const SnapshotPtr&)>;
  absl::StatusOr<WriteOutcome> Update(const MakeChanges& make, const WriteOptions& options,
                                      const WriteHooks& hooks = {});

  // Publishes the end of what pairs were allowed until `now`, if anything was. Questions that hold
  // a snapshot are answered as it says. No effect on a world that was closed.
  void ExpireRules(Clock::time_point now);

  // What Update would answer before it calls `make`: an error, the first reply of a retry, or
  // nothing. Saves the work of a write that cannot be.
  absl::StatusOr<std::optional<WriteOutcome>> Precheck(const WriteOptions& options) const;

  // The next name "<stem>_<n>" that no object and no robot of this world has, e.g. object_7; never
  // given twice. Only under the writer's turn (in `make`).
  std::string NextName(const std::string& stem);

  // The sensor's first estimated pose is kept until one is given, or an up that speaks against it.
  // Keep replaces.
  std::optional<SensorPose> PoseOf(const std::string& sensor) const;
  void KeepPose(const std::string& sensor, const SensorPose& pose);

  // What scans told of the objects; it goes with the object.
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

  // Lets go of all revisions but the latest, for their memory.
  void ForgetPast();
  // Bytes charged to this world.
  std::int64_t memory_bytes() const;

  // Ends all watches and refuses writes with NotFound WORLD_DELETED; snapshots that readers hold
  // stay good.
  void Close();
  // Ends all watches with a last bookmark, for shutting down. Writes under way still finish.
  void Drain();

 private:
  struct State;

  // A long list is applied before the turn is taken, so that others can pass it: it takes the turn
  // with what it made of the latest snapshot, and begins anew where that was another one by then.
  absl::StatusOr<WriteOutcome> ApplyOnce(std::span<const collision::Change> changes,
                                         const WriteOptions& options, WorkBudget* budget);

  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
