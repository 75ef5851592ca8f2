// The journal of all worlds: one thread that writes what they tell it to a store. All entries that
// came while the last ones were written go into one transaction, so that many writers share one
// flush of the disk (group commit).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/core/journal.h"
#include "server/core/store_admin.h"
#include "server/store/compaction.h"
#include "server/store/store.h"

namespace cwm::server {

class StoreJournal final : public Journal, public StoreAdmin {
 public:
  // Called once, from the journal's thread, if the store failed, so that it is unknown what it
  // holds: the process must end and read the store again. No entry is answered afterwards.
  using OnFailure = std::function<void(const absl::Status& status)>;

  // Gets a sentence for the log, from the journal's thread.
  using Warn = std::function<void(const std::string& text)>;

  // `store` was replayed, which made the compactor, and must have no other user.
  StoreJournal(std::unique_ptr<Store> store, Compactor compactor, OnFailure on_failure,
               Warn warn = {});
  ~StoreJournal() override;  // closes

  void Append(const JournalEntry& entry, Done done) override;
  absl::Status KeepGeometry(std::span<const PreparedModelPtr> models,
                            Durability durability) override;
  absl::StatusOr<std::string> KeepRobotFiles(const RobotFiles& files) override;

  StoreInfo info() const override;
  void StartBackup(BackupDone done) override;

  // Writes what was appended, ends the thread and closes the store. Nothing may be appended
  // afterwards.
  absl::Status Close();

 private:
  struct Item {
    StoredRecord record;
    Compactor::Logged logged;
    bool flush = false;  // a power cut must not take it
    bool may_use_reserve = false;
    absl::Status fault;  // it could not be encoded
    Done done;
  };
  using Items = std::deque<Item>;

  void Run();
  Items TakeBatch();
  void Commit(Items batch);
  static std::pair<Items, Items> SplitForReserve(Items batch);
  void Write(Items batch);
  // What became of the records; kUnknown never.
  absl::StatusOr<AppendResult> AppendToStore(const std::vector<StoredRecord>& records,
                                             Durability durability);
  absl::StatusOr<bool> HasRecord(const StoredRecord& record);
  // Answers items of which nothing was written, and all later ones of the same worlds.
  void Refuse(Items items, const absl::Status& status);
  void StepBackup();
  void StepCompaction();
  // Work that can wait.
  void WorkInBackground();
  void Fail(const absl::Status& status);

  const std::unique_ptr<Store> store_;
  const OnFailure on_failure_;
  const Warn warn_;

  // Of the journal's thread.
  Compactor compactor_;
  std::unique_ptr<Store::BackupRun> backup_run_;  // for the first of backups_
  std::int64_t not_folded_ = 0;  // logs that were too large, as far as they were told
  std::int64_t unflushed_ = 0;   // records that a power cut may take
  int batches_since_maintenance_ = 0;
  absl::Status closed_;

  std::atomic<std::int64_t> sequence_;
  std::atomic<bool> has_failed_ = false;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Items queue_;
  std::deque<BackupDone> backups_;  // asked for, oldest first
  std::string refuses_writes_;
  bool is_closing_ = false;
  std::thread thread_;  // last: starts when the other members exist
};

}  // namespace cwm::server
