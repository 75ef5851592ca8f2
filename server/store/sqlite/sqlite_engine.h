// The engine behind OpenSqliteStore.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/sqlite/ballast.h"
#include "server/store/sqlite/blob_files.h"
#include "server/store/sqlite/head_file.h"
#include "server/store/sqlite/sqlite_handles.h"
#include "server/store/sqlite/sqlite_store.h"
#include "server/store/sqlite/store_files.h"
#include "server/store/sqlite/store_rows.h"
#include "server/store/store.h"

namespace cwm::server {

class SqliteBackupRun;

class SqliteEngine final : public Store {
 public:
  static absl::StatusOr<std::unique_ptr<Store>> Open(const SqliteOptions& options);
  ~SqliteEngine() override;

  std::int64_t epoch() const override { return meta_.epoch; }
  std::int64_t last_sequence() const override { return index_.last_sequence; }
  bool may_lack_observed() const override { return meta_.lacks_observed; }
  bool may_lack_durable() const override { return meta_.lacks_durable; }
  absl::Status RecoveryDone() override;
  absl::StatusOr<AppendResult> Append(std::span<const StoredRecord> records,
                                      Durability durability) override;
  absl::StatusOr<std::vector<StoredRecord>> Follow(std::string_view world_uid, std::int64_t after,
                                                   std::int64_t max_bytes) override;
  absl::Status PutSnapshot(const StoredSnapshot& snapshot) override;
  absl::StatusOr<std::vector<StoredSnapshot>> Snapshots() override;
  absl::StatusOr<std::optional<StoredSnapshot>> SnapshotOf(std::string_view world_uid) override;
  absl::Status DropWorld(std::string_view world_uid, std::int64_t sequence) override;
  absl::Status PutBlob(const std::string& hash, std::string_view bytes,
                       Durability durability) override;
  absl::StatusOr<std::string> GetBlob(const std::string& hash) const override;
  bool HasDurableBlob(const std::string& hash) const override;
  absl::Status Maintain() override;
  absl::Status CheckRoom() override;
  absl::StatusOr<std::unique_ptr<BackupRun>> StartBackup() override;
  StoreStats stats() const override;
  absl::Status Close() override;

 private:
  friend class SqliteBackupRun;

  SqliteEngine(const SqliteOptions& options, FileDescriptor lock);
  absl::Status Load();
  absl::Status OpenDatabase();
  absl::Status LoadRows();
  void Warn(const std::string& text) const;
  // The text with the directory before it, unless it begins with a path in there.
  std::string Located(const std::string& text) const;
  absl::Status BeginEpoch();
  absl::Status PrepareStatements();

  // Runs the work in one transaction. A failure of the disk ends the use of the store.
  absl::Status InTransaction(Durability durability, const std::function<absl::Status()>& work);
  // The same, and once more without the ballast if there is no room.
  absl::Status WithBallast(const std::function<absl::Status()>& work);
  absl::Status SetSynchronous(Durability durability);
  // Returns the status, and remembers it if the store must not be used any more.
  absl::Status Noted(absl::Status status);
  // The same on any thread, for blobs.
  absl::Status NotedAnywhere(absl::Status status) const;
  // The failure that ended the use of the store, or OK.
  absl::Status Failure() const;
  // Replaces the snapshot of a world, or marks the world as dropped, up to the snapshot's sequence.
  absl::Status ReplaceSnapshot(const StoredSnapshot& snapshot, bool is_dropped);
  // Reads the row of a world's snapshot, and checks it.
  absl::StatusOr<StoredSnapshot> ReadSnapshot(std::string_view world_uid,
                                              const SnapshotEntry& entry, Statement& row);
  absl::Status DeleteObsolete();
  absl::Status DeleteDropped();
  // Moves the log into the database; true if all of it was moved.
  absl::StatusOr<bool> Checkpoint(bool truncate);
  absl::Status RemoveUnusedBlobs(std::chrono::steady_clock::duration grace);
  // The room for records and blobs: what is free, less what the ballast needs to be restored.
  // Thread safe.
  std::int64_t RoomBytes() const;
  // DISK_FULL if less than the low-water mark is left when so many bytes more are written. Thread
  // safe.
  absl::Status CheckRoomFor(std::int64_t bytes) const;
  void PublishCounts();

  const SqliteOptions options_;
  const std::string directory_;
  FileDescriptor lock_;
  Database database_;
  Statement insert_record_;
  Statement read_records_;
  Statement read_record_;
  Statement delete_record_;
  HeadFile head_file_;
  Head head_;
  std::unique_ptr<BlobFiles> blobs_;
  Ballast ballast_;

  StoreMeta meta_;
  StoreIndex index_;
  Durability synchronous_ = Durability::kDurable;
  int log_pages_ = 0;  // that are not yet in the database
  std::chrono::steady_clock::time_point last_append_ = {};
  absl::Status failed_;
  bool is_closed_ = false;
  SqliteBackupRun* backup_run_ = nullptr;

  mutable std::mutex blob_mutex_;  // guards blob_failure_
  mutable absl::Status blob_failure_;
  mutable std::atomic<bool> blobs_have_failed_ = false;

  // Copies for stats(), which any thread may call.
  std::atomic<std::int64_t> record_count_ = 0;
  std::atomic<std::int64_t> record_bytes_ = 0;
};

}  // namespace cwm::server
