// The published side of a world: its latest snapshot, its history and who watches. One writer at a
// time publishes (the world's turn sees to it); any number of threads read.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/history.h"
#include "server/core/watch.h"
#include "server/core/world.h"

namespace cwm::server {

// Why a world publishes to its watches no more.
enum class Ending { kNone, kDraining, kDeleted };

class WorldFeed {
 public:
  using Wake = std::function<void()>;

  // What remains to be done after publishing, with no lock held (the writer's turn neither):
  // watches are woken by Finish, forgotten geometry is freed by the destructor.
  struct Aftermath {
    std::vector<std::shared_ptr<const Wake>> wakes;
    History::Forgotten forgotten;
    void Finish() const;
  };

  // What a lossless reader finds next.
  struct Look {
    EventPtr event;                    // the one that made the revision after the position
    bool compacted = false;            // it was made and is no longer kept
    collision::Revision oldest_watch;  // where a watch could resume
    Ending ending = Ending::kNone;
  };

  // Where a watch begins.
  struct Start {
    SnapshotPtr latest;
    std::vector<EventPtr> missed;  // after from_revision, where the snapshot is not kept
    SnapshotPtr from;              // the exact snapshot of from_revision, where it is kept
    std::shared_ptr<const Wake> subscription;
  };

  WorldFeed(Retention retention, std::function<Clock::time_point()> now, MemoryCharge charge = {});

  SnapshotPtr Latest() const;
  Ending ending() const;
  absl::StatusOr<SnapshotPtr> At(const RevisionRule& rule, Clock::time_point deadline,
                                 std::stop_token stop) const;
  collision::Revision oldest_exact() const;
  collision::Revision oldest_watch();

  // `next` follows the latest snapshot by one revision.
  [[nodiscard]] Aftermath Publish(SnapshotPtr next, std::vector<collision::ObjectDelta> deltas,
                                  std::vector<collision::RobotDelta> robot_deltas,
                                  std::vector<collision::PairRuleDelta> rule_deltas);
  // Deletion follows draining, not the other way round.
  [[nodiscard]] Aftermath End(Ending ending);

  // Lets go of what is remembered of the past: only the latest revision can be read or resumed
  // from.
  void ForgetPast();

  // Atomically: what was published before is in the start, what comes after wakes.
  absl::StatusOr<Start> Subscribe(const WatchOptions& options, Wake wake);
  void Unsubscribe(const std::shared_ptr<const Wake>& subscription);
  Look LookAfter(collision::Revision position) const;

 private:
  absl::StatusOr<SnapshotPtr> Exact(collision::Revision revision) const;
  absl::StatusOr<SnapshotPtr> WaitFor(collision::Revision revision, Clock::time_point deadline,
                                      std::stop_token stop) const;
  absl::Status CheckResume(collision::Revision from) const;

  const std::function<Clock::time_point()> now_;

  mutable std::mutex latest_mutex_;  // held for the copy of the pointer alone
  SnapshotPtr latest_;

  mutable std::mutex mutex_;  // of all below; never held while working or calling out
  mutable std::condition_variable_any published_or_ended_;
  History history_;
  std::vector<std::shared_ptr<const Wake>> subscriptions_;
  Ending ending_ = Ending::kNone;
};

// The error of a world that was deleted.
absl::Status WorldDeleted();

// Starts a watch on the feed, which it keeps alive.
absl::StatusOr<std::unique_ptr<WatchCursor>> StartWatch(std::shared_ptr<WorldFeed> feed,
                                                        const WatchOptions& options,
                                                        WorldFeed::Wake wake);

}  // namespace cwm::server
