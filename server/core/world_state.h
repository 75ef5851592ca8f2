// The writers' side of a world: decides writes on the newest state and publishes them. Internal to
// World; the functions that say so are called under the writer's turn.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

#include "server/core/commit_pipeline.h"
#include "server/core/idempotency_cache.h"
#include "server/core/kept_views.h"
#include "server/core/live/robot_states.h"
#include "server/core/rule_expiry.h"
#include "server/core/world.h"
#include "server/core/world_feed.h"

namespace cwm::server {

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
  std::set<std::string> unsaved_stems = {};  // whose numbers no entry has yet; under the turn
  bool has_entries = false;                  // the journal knows the world; under the turn
  bool is_closed = false;                    // no write follows; under the turn

  mutable std::mutex sensors_mutex;
  std::unordered_map<std::string, SensorPose> sensor_poses;  // as the writes on the tip told them
  std::unordered_map<std::string, SensorPose> journaled_poses;

  std::mutex expiry_mutex;  // so that the last call of ScheduleExpiry is about the latest revision

  Observations observations;
  KeptScans scans;
  KeptViews views;
  RobotStates robot_states;
  World* const world;
  std::optional<CommitPipeline> pipeline = {};  // its tip is what writes are decided on

  // Under the turn. The checks of a write that precede its changes: an error, the first reply of a
  // retry, or empty to go on.
  absl::StatusOr<std::optional<WriteOutcome>> Precheck(const WriteOptions& options);

  // Sets the time of the next expiry of the latest rules.
  void ScheduleExpiry();

  // Geometry that a change brings is charged to the world for as long as anything refers to it.
  absl::Status ChargeGeometry(const collision::WorldSnapshot& base,
                              std::vector<collision::Change>& changes) const;

  // Stores the large geometry of what the changes put, and of what durable changes are about: a
  // power cut must not take an object with the attachment that a user was promised.
  absl::Status KeepGeometryOf(std::span<const collision::Change> changes,
                              Durability durability) const;

  absl::Status CheckObjectCount(const collision::WorldSnapshot& base,
                                const collision::WorldSnapshot& next) const;

  // A list of changes and its effect on a snapshot. Made without a lock.
  struct Applied {
    SnapshotPtr base, next;
    std::vector<collision::ObjectDelta> deltas;
    std::vector<collision::RobotDelta> robot_deltas;
    std::vector<collision::PairRuleDelta> rule_deltas;
  };
  absl::StatusOr<Applied> ApplyTo(const SnapshotPtr& base, std::span<const collision::Change> given,
                                  WorkBudget* budget) const;

  // Runs `write` again while it lacks memory: forgets the past and the kept views, first of this
  // world, then of all.
  absl::Status WithRoom(const std::function<absl::Status()>& write);

  using MakeApplied = std::function<absl::StatusOr<Applied>(const SnapshotPtr& base)>;

  // Under the turn.
  PendingWritePtr Decide(const MakeApplied& make, const WriteOptions& options,
                         const WriteHooks& hooks);

  // Under the turn. Fills the entry of a write that succeeded.
  WriteOutcome Accept(Applied applied, const WriteOptions& options, const WriteHooks& hooks,
                      PendingWrite& write);

  // Under the turn.
  void SetEntry(PendingWrite& write, collision::Revision revision,
                std::variant<WorldWrite, WorldDeletion> what, Durability durability,
                bool may_use_reserve);

  // Called by the pipeline: makes a write visible to readers.
  WorldFeed::PostCommit Publish(const PendingWrite& write);

  // Called by the pipeline, under the turn: undoes the writes. Numbers of names stay used, so that
  // none is ever given twice.
  void RollBack(const std::deque<PendingWritePtr>& lost);

  // Under the turn. The pipeline must not outlive its world.
  CommitPipeline::AfterTurn Push(PendingWritePtr write, WriteDone done);

  // Takes the turn. OK if the write was decided, whatever the answer that `done` gets;
  // MEMORY_EXHAUSTED if it may succeed with more room, with `done` not called.
  absl::Status Write(const MakeApplied& make, const WriteOptions& options, const WriteHooks& hooks,
                     WriteDone& done);
};

}  // namespace cwm::server
