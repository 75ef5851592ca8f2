// The exact snapshots that a world keeps: the newest ones, older ones thinned by age, and those
// that somebody uses. Values and limits only: not thread safe, no clock of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "collision/world/world_snapshot.h"
#include "server/core/limits.h"
#include "server/core/watch.h"

namespace cwm::server {

// Keeps at most Retention::exact_snapshots, and beyond them those of the last
// Retention::recent_time and the leased ones. If the newest so many revisions were made at no more
// than ten a second, exactly these are kept. Else those of the last second are kept, of the ten
// seconds before them the first of each tenth of a second, and of the time before that the first of
// each second; the oldest fall when nothing else is left to thin. Leases change nothing of that:
// one that would fall is kept for as long as it is leased. One that somebody holds when it would
// fall, such as a query that is being answered, counts as used then.
class KeptSnapshots {
 public:
  // The cost of a revision, for the limits of memory.
  struct Cost {
    std::size_t changed_count = 0;      // of objects and robots
    std::int64_t superseded_bytes = 0;  // that the revision took out of the world
  };

  KeptSnapshots(const Retention& retention, SnapshotPtr first);

  // `next` follows the latest snapshot and was made at `when`, not before any earlier one. The
  // caller frees what is added to `dropped`.
  void Append(SnapshotPtr next, Clock::time_point when, const Cost& cost,
              std::vector<SnapshotPtr>& dropped);
  // Drops snapshots that only leases kept which have ended.
  void EndLeases(Clock::time_point now, std::vector<SnapshotPtr>& dropped);
  // Drops all but the latest, leased or not.
  void DropAllButLatest(std::vector<SnapshotPtr>& dropped);

  const SnapshotPtr& latest() const { return kept_.back().snapshot; }
  // The oldest that is kept without a lease.
  collision::Revision oldest() const;
  // The kept one with the nearest revision, of two the newer one.
  collision::Revision NearestTo(collision::Revision revision) const;
  // nullptr if it is not kept.
  SnapshotPtr Find(collision::Revision revision) const;
  // Leases it from now on for Retention::lease_time. nullptr if it is not kept.
  SnapshotPtr Use(collision::Revision revision, Clock::time_point now);

  // The memory of the snapshots themselves, without the objects, which they share.
  std::int64_t own_bytes() const { return own_bytes_; }
  std::size_t size() const { return kept_.size(); }
  // How many only a lease keeps.
  std::size_t leased_count() const { return leased_count_; }

 private:
  struct Kept {
    SnapshotPtr snapshot;
    std::int64_t ordinal = 0;           // counts the revisions that were made
    Clock::time_point made;             // when its revision was made
    Clock::time_point superseded;       // when the next revision was made; max: it is the latest
    Clock::time_point used;             // by the last Use
    bool only_leased = false;           // else it is kept without a lease
    std::int64_t path_bytes = 0;        // that it does not share with the kept one before
    std::int64_t rule_bytes = 0;        // of rules that the next kept one does not have
    std::int64_t superseded_bytes = 0;  // of objects that the next kept one does not have

    std::int64_t own_bytes() const { return path_bytes + rule_bytes; }
    std::int64_t bytes() const { return own_bytes() + superseded_bytes; }
  };
  using Iterator = std::deque<Kept>::iterator;

  std::int64_t unleased_count() const;
  std::int64_t MaxCount(Clock::time_point now) const;
  bool IsSlow() const;
  Iterator NextToFall(Clock::time_point now);
  bool IsLeased(Kept& kept, Clock::time_point now) const;
  void Shrink(Clock::time_point now, std::vector<SnapshotPtr>& dropped);
  void ShrinkLeased(std::vector<SnapshotPtr>& dropped);
  void Drop(Iterator which, std::vector<SnapshotPtr>& dropped);
  void CountBytes(const Kept& kept, int sign);

  Retention retention_;
  std::deque<Kept> kept_;  // in order of revisions, never empty; the last is not only leased
  std::size_t leased_count_ = 0;
  std::int64_t own_bytes_ = 0;
  std::int64_t unleased_bytes_ = 0;  // with the objects that only the history holds
  std::int64_t leased_bytes_ = 0;    // likewise, of those that only a lease keeps
};

}  // namespace cwm::server
