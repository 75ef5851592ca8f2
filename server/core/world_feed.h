// The published side of a world: its latest snapshot, its history and its watches. One writer at a
// time publishes (the writer's turn ensures it); any number of threads read.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/history.h"
#include "server/core/watch.h"
#include "server/core/world.h"

namespace cwm::server {

// The reason why a world publishes no more to its watches.
enum class EndReason { kNone, kDraining, kDeleted };

class WorldFeed {
 public:
  using Wake = std::function<void()>;

  // The work left after publishing, to be done without any lock (nor the writer's turn): Finish
  // wakes the watches, the destructor frees dropped geometry.
  struct PostCommit {
    std::vector<std::shared_ptr<const Wake>> wakes;
    History::Dropped dropped;
    void Finish() const;
  };

  // The next event for a lossless reader.
  struct ReadResult {
    EventPtr event;                    // the event of the revision after the position
    bool compacted = false;            // that revision was made but is no longer kept
    collision::Revision oldest_watch;  // the oldest revision where a watch could resume
    EndReason end_reason = EndReason::kNone;
  };

  // The starting point of a watch.
  struct Start {
    SnapshotPtr latest;
    std::vector<EventPtr> missed;  // events after from_revision, if its snapshot is not kept
    SnapshotPtr from;              // the exact snapshot of from_revision, if it is kept
    std::shared_ptr<const Wake> subscription;
  };

  // `first` is the oldest revision that is kept.
  WorldFeed(Retention retention, std::function<Clock::time_point()> now, MemoryCharge charge = {},
            SnapshotPtr first = std::make_shared<const collision::WorldSnapshot>());

  SnapshotPtr Latest() const;
  EndReason end_reason() const;
  absl::StatusOr<SnapshotPtr> At(const RevisionRule& rule, Clock::time_point deadline,
                                 std::stop_token stop) const;
  collision::Revision oldest_exact() const;
  collision::Revision oldest_watch();

  // Adds the events that led from `from` to the first snapshot, before anything is published.
  void RestoreEvents(std::span<const EventPtr> events, collision::Revision from);
  // `event` made `next` of the latest snapshot (History::Append).
  [[nodiscard]] PostCommit Publish(SnapshotPtr next, EventPtr event);
  // Deletion may follow draining, but not the other way round.
  [[nodiscard]] PostCommit End(EndReason end_reason);

  // Drops the past: only the latest revision can be read or resumed from.
  void DropHistory();

  // Atomic: everything published before is in the start, and everything after wakes.
  absl::StatusOr<Start> Subscribe(const WatchOptions& options, Wake wake);
  // Wakes at every later publication and end, without a position.
  std::shared_ptr<const Wake> Subscribe(Wake wake);
  void Unsubscribe(const std::shared_ptr<const Wake>& subscription);
  ReadResult ReadAfter(collision::Revision position) const;

 private:
  absl::StatusOr<SnapshotPtr> Exact(collision::Revision revision) const;
  absl::StatusOr<SnapshotPtr> WaitFor(collision::Revision revision, Clock::time_point deadline,
                                      std::stop_token stop) const;
  absl::Status CheckResume(collision::Revision from) const;

  const std::function<Clock::time_point()> now_;

  mutable std::mutex latest_mutex_;  // held only while the pointer is copied
  SnapshotPtr latest_;

  mutable std::mutex mutex_;  // guards the members below; never held while working or calling out
  mutable std::condition_variable_any published_or_ended_;
  mutable History history_;  // asking for a revision leases it
  std::vector<std::shared_ptr<const Wake>> subscriptions_;
  EndReason end_reason_ = EndReason::kNone;
};

// NotFound WORLD_DELETED.
absl::Status WorldDeleted();

// Starts a watch on the feed, which it keeps alive.
absl::StatusOr<std::unique_ptr<WatchCursor>> StartWatch(std::shared_ptr<WorldFeed> feed,
                                                        const WatchOptions& options,
                                                        WorldFeed::Wake wake);

}  // namespace cwm::server
