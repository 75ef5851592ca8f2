// Keeps the log of each world short: folds records that nobody needs one by one into a snapshot.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/status.h"
#include "server/core/journal.h"
#include "server/core/limits.h"
#include "server/store/encode_shapes.h"
#include "server/store/history_window.h"
#include "server/store/store.h"
#include "server/store/world_fold.h"

namespace cwm::server {

// Folds the records of one world, up to a sequence, into its snapshot, in steps short enough to
// append between two of them. What was done before the last step is void if it is not taken.
class Compaction {
 public:
  // chosen: an engine keeps a row of 1 GB (SQLITE_MAX_LENGTH), and this leaves it some.
  static constexpr std::int64_t kMaxSnapshotBytes = 900'000'000;

  // `up_to` is the sequence of a record of the world. A snapshot of more than `max_snapshot_bytes`
  // of payload is not made.
  Compaction(std::string world_uid, std::int64_t up_to, const Retention& retention,
             std::int64_t max_snapshot_bytes = kMaxSnapshotBytes);

  // The errors of the store; DataLoss STORE_DAMAGED for records that do not follow. After DISK_FULL
  // the step can be taken again.
  absl::Status Step(Store& store);
  bool done() const { return stage_ == Stage::kDone; }
  // The snapshot would be too large for the store, so the log is left as it is.
  bool is_too_large() const { return is_too_large_; }

 private:
  enum class Stage { kReadSnapshot, kReadRecords, kAddObjects, kPutSnapshot, kDone };

  absl::Status ReadSnapshot(Store& store);
  absl::Status ReadRecords(Store& store);
  absl::Status BeginSnapshot(const Store& store);
  absl::Status AddObjects(const Store& store);
  absl::Status Append(const store::v1::WorldSnapshot& part, const Store& store);
  absl::Status PutSnapshot(Store& store);
  void GiveUp();

  const std::string world_uid_;
  const std::int64_t up_to_;
  const Retention retention_;
  const std::int64_t max_snapshot_bytes_;
  Stage stage_ = Stage::kReadSnapshot;
  WorldFold fold_;
  std::int64_t sequence_ = 0;  // of the last folded record
  std::vector<FoldedObjectPtr> objects_;
  std::size_t added_objects_ = 0;
  BlobHashes blobs_;
  StoredSnapshot snapshot_;
  bool is_too_large_ = false;
};

// Decides when a log is folded, from what it was told of each record, and folds it step by step.
// Used by one thread.
class Compactor {
 public:
  struct Limits {
    // chosen: the records that a restart reads in vain are at most so many, or have so many bytes:
    // some tenths of a second.
    std::int64_t max_records = 50'000;
    std::int64_t max_bytes = std::int64_t{16} << 20;
    std::int64_t max_snapshot_bytes = Compaction::kMaxSnapshotBytes;
  };
  // chosen: so long nothing is tried after the disk was full.
  static constexpr std::chrono::seconds kWaitWhenFull = std::chrono::seconds(10);

  Compactor(const Retention& retention, const Limits& limits)
      : retention_(retention), limits_(limits) {}
  explicit Compactor(const Retention& retention = {}) : Compactor(retention, Limits()) {}

  // To be told of every record that is in the log, in order: first by a replay, then of each that
  // is appended.
  struct Logged {
    std::string world_uid = {};
    std::int64_t sequence = 0;
    std::int64_t when_ns = 0;
    std::int64_t changes = 0;  // Event::size(); 0: it makes no revision
    std::int64_t bytes = 0;    // of its payload
    bool is_deletion = false;
    bool drops_past = false;  // nobody needs the records before it, nor may they be folded alone
  };
  void Add(const Logged& record);
  // The record of an entry, without sequence and bytes.
  static Logged LoggedOf(const JournalEntry& entry);

  bool IsDue(collision::WallTime now) const;
  // Takes one step, if one is due. The errors of Compaction::Step. After DISK_FULL nothing is due
  // for kWaitWhenFull.
  absl::Status Step(Store& store, collision::WallTime now);
  // How often a log was left as it is, since the snapshot of its world would be too large. Such a
  // log is tried again when it has doubled.
  std::int64_t not_folded() const { return not_folded_; }

 private:
  struct Kept {
    std::int64_t sequence = 0;
    std::int64_t bytes = 0;
  };
  struct Log {
    HistoryWindow window;
    std::deque<Kept> kept = {};  // the records of the window
    // Records that left the window since the last compaction began: count, bytes, last sequence.
    std::int64_t old_records = 0, old_bytes = 0, old_sequence = 0;
    // The same counts when the compaction under way began.
    std::int64_t begun_records = 0, begun_bytes = 0;
    std::int64_t max_records = 0, max_bytes = 0;  // it is due above one of them
    bool is_due = false;
  };
  struct Deleted {
    std::string world_uid = {};
    std::int64_t sequence = 0;
    std::int64_t when_ns = 0;
  };

  bool MayDrop(const Deleted& deleted, collision::WallTime now) const;
  bool IsPaused(collision::WallTime now) const;
  absl::Status TryStep(Store& store, collision::WallTime now);
  absl::Status StepCurrent(Store& store);
  static bool IsLong(const Log& log);
  static void LeaveWindow(Log& log);

  Retention retention_;
  Limits limits_;
  std::unordered_map<std::string, Log> logs_;  // by world
  std::deque<std::string> due_;                // worlds whose log is too long
  std::deque<Deleted> deleted_;                // oldest first
  std::unique_ptr<Compaction> current_;
  std::string current_uid_;                             // its world
  std::optional<collision::WallTime> full_since_ = {};  // the last step found the disk full
  std::int64_t not_folded_ = 0;
};

}  // namespace cwm::server
