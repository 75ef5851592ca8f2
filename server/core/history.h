// The past of one world: exact snapshots, and the log of events that watches read. Values and
// limits only: not thread safe, no clock of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "collision/world/world_snapshot.h"
#include "server/core/kept_snapshots.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/watch.h"

namespace cwm::server {

// All changes of one revision, by name.
struct Event {
  collision::Revision revision;
  Clock::time_point when;
  absl::InlinedVector<collision::ObjectDelta, 1> deltas;  // usually one
  std::vector<collision::RobotDelta> robot_deltas = {};
  std::vector<collision::PairRuleDelta> rule_deltas = {};

  std::int64_t size() const {
    return static_cast<std::int64_t>(deltas.size() + robot_deltas.size() + rule_deltas.size());
  }
};
using EventPtr = std::shared_ptr<const Event>;

class History {
 public:
  // Dropped data; the caller frees it after releasing its locks.
  struct Dropped {
    std::vector<SnapshotPtr> snapshots;
    std::vector<EventPtr> events;
  };

  // `charge` is kept equal to the bytes of the history, without the geometry of objects, whose
  // memory is charged with them.
  History(Retention retention, SnapshotPtr first, MemoryCharge charge = {});
  // Adds the events that led from `from` to the first snapshot, oldest first; before any Append.
  void RestoreEvents(std::span<const EventPtr> events, collision::Revision from);

  // `next` is the snapshot that `event` led to, usually one revision after the latest. Revisions
  // between the two were lost in a power cut: they count as no longer kept.
  Dropped Append(SnapshotPtr next, EventPtr event);
  // Forgets events that are older than the watch time and snapshots whose leases have ended.
  Dropped Expire(Clock::time_point now);
  // Forgets all but the latest snapshot and its event.
  Dropped DropHistory();

  collision::Revision latest() const { return snapshots_.latest()->revision(); }
  // Between this revision and the latest some may have been thinned; older ones are kept for those
  // who use them.
  collision::Revision oldest_exact() const { return snapshots_.oldest(); }
  // The kept revision that is nearest to the given one.
  collision::Revision NearestExact(collision::Revision revision) const {
    return snapshots_.NearestTo(revision);
  }
  // A watch can resume from here on: all later events are kept.
  collision::Revision oldest_watch() const;
  // False for a revision that was lost in a power cut or is yet to be made.
  bool WasMade(collision::Revision revision) const;

  // nullptr if it is no longer kept, or not yet made.
  SnapshotPtr SnapshotAt(collision::Revision revision) const { return snapshots_.Find(revision); }
  // Likewise; leases the snapshot from now on.
  SnapshotPtr Use(collision::Revision revision, Clock::time_point now) {
    return snapshots_.Use(revision, now);
  }
  // The event that was applied to the revision; nullptr if it is no longer kept, or not yet made.
  EventPtr EventFrom(collision::Revision revision) const;
  // The events after a revision from oldest_watch() on. Undoing them from the latest snapshot gives
  // the world at that revision even if its snapshot is no longer kept.
  std::vector<EventPtr> EventsAfter(collision::Revision revision) const;

 private:
  struct KeptEvent {
    EventPtr event;
    collision::Revision before;  // the revision to which it was applied
    std::int64_t own_bytes = 0;
    std::int64_t bytes = 0;  // own_bytes and the bytes that its revision took out of the world
  };

  // Bytes that the event's revision took out of the world.
  static std::int64_t SupersededBytes(const Event& event);
  void AddEvent(EventPtr event, collision::Revision before);
  void ExpireEvents(Clock::time_point now, Dropped& dropped);
  void ShrinkEvents(Dropped& dropped);
  void DropOldestEvent(Dropped& dropped);
  void UpdateCharge() { charge_.ForceResize(snapshots_.own_bytes() + own_event_bytes_); }

  Retention retention_;
  KeptSnapshots snapshots_;
  std::deque<KeptEvent> events_;  // in order, each applied to the result of the one before
  MemoryCharge charge_;
  std::int64_t own_event_bytes_ = 0;
  std::int64_t event_bytes_ = 0;
  std::int64_t event_deltas_ = 0;
};

// The snapshot before `events` (in order), made by undoing them from `latest`.
SnapshotPtr UndoEvents(const collision::WorldSnapshot& latest, const std::vector<EventPtr>& events,
                       collision::Revision revision);

}  // namespace cwm::server
