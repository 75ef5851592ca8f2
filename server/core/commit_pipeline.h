// The writes of a world between their decision and their publication. A write is decided on the
// tip, which runs ahead of what readers see; it is published and answered when the journal has it,
// in the order of decisions. So many writers share one flush of the disk, and no reader ever sees
// what a crash could take back. Without a journal a write is published at once.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/journal.h"
#include "server/core/world.h"
#include "server/core/world_feed.h"

namespace cwm::server {

// A decided write.
struct PendingWrite {
  absl::StatusOr<WriteOutcome> outcome = absl::UnknownError("the write was not decided");
  WriteDone done = {};
  JournalEntry entry = {};
  SnapshotPtr next = {};  // the world after it; nullptr: the write makes no revision
  // False: an answer that was derived from the tip, so that it must not leave before the tip is
  // journaled: an error, the reply to a retry, a write without effect.
  bool has_entry = false;
  bool is_void = false;  // it was rolled back; under the turn
};
using PendingWritePtr = std::shared_ptr<PendingWrite>;

class CommitPipeline {
 public:
  struct Owner {
    // Publishes a write that the journal has, or that needs none.
    std::function<WorldFeed::PostCommit(const PendingWrite&)> publish;
    // Called under the writer's turn after writes were rolled back: the tip is the latest published
    // snapshot again.
    std::function<void(const std::deque<PendingWritePtr>& lost)> roll_back;
  };

  // `journal` may be null. `turn` is the writer's turn; `latest` returns the newest published
  // snapshot.
  CommitPipeline(Journal* journal, std::mutex& turn, std::function<SnapshotPtr()> latest,
                 Owner owner);

  // The newest decided snapshot.
  SnapshotPtr Tip() const;
  // The number of writes that wait for the journal.
  std::size_t size() const;

  // The work left after a push, to be done without the turn.
  struct AfterTurn {
    WorldFeed::PostCommit post_commit = {};
    PendingWritePtr answered = {};
    void Finish() const;
  };
  // Under the turn. `keep_alive` keeps the pipeline until the journal has called back. A lack of
  // memory here ends the process: tip and journal would differ, while a restart finds all that was
  // answered.
  AfterTurn Push(PendingWritePtr write, std::shared_ptr<const void> keep_alive) noexcept;

 private:
  void OnJournaled(const PendingWritePtr& write);
  void OnRefused(const PendingWritePtr& write, const absl::Status& status);

  Journal* const journal_;
  std::mutex& turn_;
  const std::function<SnapshotPtr()> latest_;
  const Owner owner_;

  mutable std::mutex mutex_;           // a leaf; guards the members below
  SnapshotPtr tip_;                    // nullptr: the latest published snapshot
  std::deque<PendingWritePtr> queue_;  // oldest first; the first one has an entry
};

}  // namespace cwm::server
