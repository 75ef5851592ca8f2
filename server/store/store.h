// A store of records, snapshots and blobs: the interface that each engine implements. It knows
// nothing of worlds beyond their uids; payloads are opaque (store_journal.h encodes them).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/core/journal.h"
#include "server/core/store_admin.h"

namespace cwm::server {

struct StoredRecord {
  std::int64_t sequence = 0;  // of all worlds together: 1, 2, ... without a hole
  std::int64_t epoch = 0;     // Store::epoch() of the server that wrote it
  std::string world_uid = {};
  std::int64_t revision = 0;  // of the world after it
  std::string payload = {};
  std::vector<std::string> blobs = {};  // hashes of the blobs that the payload names
};

// The state of one world after all its records up to `sequence`.
struct StoredSnapshot {
  std::int64_t sequence = 0;
  std::string world_uid = {};
  std::int64_t revision = 0;
  std::string payload = {};
  std::vector<std::string> blobs = {};
};

enum class AppendResult {
  kDurable,     // all records survive, as their durability promises
  kSuperseded,  // none was appended: another server appended first, see Follow
  kUnknown,     // the reply was lost: Follow tells whether the records are there
};

struct StoreStats {
  std::string location = {};  // "sqlite:/var/lib/cwm"
  std::int64_t record_count = 0;
  std::int64_t record_bytes = 0;  // payloads that are not yet folded into snapshots
  std::int64_t bytes = 0;         // of all files
  std::int64_t blob_count = 0;
};

// All functions but PutBlob, GetBlob, HasDurableBlob and stats are called by one thread at a time:
// the journal's, or, while the server starts, the one that replays.
//
// Errors: ResourceExhausted DISK_FULL, or OUT_OF_FILES if no file could be opened: nothing was
// written, and the call may be repeated. ResourceExhausted SNAPSHOT_TOO_LARGE: nothing was written,
// because the engine can hold no row of this size. DataLoss STORE_DAMAGED: what was read is not
// what was written; the message names the place. Unavailable STORE_FAILED: reading or writing
// failed, and it is unknown what of the call's data was written; the store must not be used any
// more.
class Store {
 public:
  virtual ~Store() = default;

  // How often the store was opened to append, this time included.
  virtual std::int64_t epoch() const = 0;
  // The sequence of the newest record; 0 for none.
  virtual std::int64_t last_sequence() const = 0;
  // True if the newest observed records may be missing: the machine went down, or the file system
  // was taken away, since the store was last open, and it was not closed. A process that was killed
  // loses nothing.
  virtual bool may_lack_observed() const = 0;
  // True if acknowledged records of any number may be missing: a backup was restored, or a loss was
  // accepted.
  virtual bool may_lack_durable() const = 0;
  // Says that the reader of the store has stored, durably, how it goes on after such a loss. Until
  // then each opening tells of the loss again.
  virtual absl::Status RecoveryDone() = 0;

  // Appends all records or none. The first has the sequence last_sequence() + 1. kDurable data is
  // on the disk when the function returns, together with all earlier records.
  virtual absl::StatusOr<AppendResult> Append(std::span<const StoredRecord> records,
                                              Durability durability) = 0;
  // Reads, in order, records with a sequence above `after`: of one world, or of all for an empty
  // uid. At least one if there is one, then as many as have `max_bytes` of payload.
  virtual absl::StatusOr<std::vector<StoredRecord>> Follow(std::string_view world_uid,
                                                           std::int64_t after,
                                                           std::int64_t max_bytes) = 0;

  // Replaces the world's snapshot, and drops its records up to the snapshot's sequence.
  virtual absl::Status PutSnapshot(const StoredSnapshot& snapshot) = 0;
  virtual absl::StatusOr<std::vector<StoredSnapshot>> Snapshots() = 0;
  // The snapshot of one world; empty if there is none.
  virtual absl::StatusOr<std::optional<StoredSnapshot>> SnapshotOf(std::string_view world_uid) = 0;
  // Drops the snapshot of a world, and its records up to `sequence`.
  virtual absl::Status DropWorld(std::string_view world_uid, std::int64_t sequence) = 0;

  // Keeps the bytes under their SHA-256, in lower-case hex, which the caller has computed. A
  // durable blob is on the disk when the function returns; an observed one may be lost in a power
  // cut. Maintain drops blobs that no record or snapshot names, ten minutes after they were last put at
  // the earliest, so that the record has time to follow. Thread safe.
  virtual absl::Status PutBlob(const std::string& hash, std::string_view bytes,
                               Durability durability) = 0;
  // NotFound BLOB_MISSING; DataLoss STORE_DAMAGED if the bytes do not have the hash. Thread safe.
  virtual absl::StatusOr<std::string> GetBlob(const std::string& hash) const = 0;
  // True if the blob was put durably, so that it need not be put again: it is kept from now on as
  // if it were. Thread safe.
  virtual bool HasDurableBlob(const std::string& hash) const = 0;
  // Work that can wait: moves the log into the database, drops unused blobs, makes room. Called
  // when nothing is to be appended, and now and then otherwise. Takes at most tens of milliseconds.
  virtual absl::Status Maintain() = 0;
  // OK if there is room to append; else DISK_FULL, after having tried to make some.
  virtual absl::Status CheckRoom() = 0;

  // Takes one step of a backup, short enough to append between two steps; nullptr until it is
  // complete.
  class BackupRun {
   public:
    virtual ~BackupRun() = default;
    virtual absl::StatusOr<std::unique_ptr<Backup>> Step() = 0;
  };
  virtual absl::StatusOr<std::unique_ptr<BackupRun>> StartBackup() = 0;

  virtual StoreStats stats() const = 0;  // thread safe

  // Closes the store: everything is on the disk, and nothing is lost before it is opened again.
  virtual absl::Status Close() = 0;
};

}  // namespace cwm::server
