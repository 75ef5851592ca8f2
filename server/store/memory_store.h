// A store in memory: what tests of the layers above use, and what the contract of stores is checked
// against. It keeps everything until it is destroyed.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/store.h"

namespace cwm::server {

// Outlives a MemoryStore, as a disk outlives a process: a store opened on it again is one after a
// restart.
struct MemoryDisk {
  std::int64_t epoch = 0;
  std::int64_t last_sequence = 0;
  std::map<std::int64_t, StoredRecord> records = {};
  std::map<std::string, StoredSnapshot, std::less<>> snapshots = {};  // by world
  std::map<std::string, std::string, std::less<>> blobs = {};         // by hash
};

class MemoryStore final : public Store {
 public:
  explicit MemoryStore(std::shared_ptr<MemoryDisk> disk = std::make_shared<MemoryDisk>());

  std::int64_t epoch() const override { return epoch_; }
  std::int64_t last_sequence() const override;
  bool may_lack_observed() const override { return false; }
  bool may_lack_durable() const override { return false; }
  absl::Status RecoveryDone() override { return absl::OkStatus(); }
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
  absl::Status Maintain() override { return absl::OkStatus(); }
  absl::Status CheckRoom() override { return absl::OkStatus(); }
  // The files of a backup are copies in a temporary folder: "records" of all records and snapshots,
  // and the blobs.
  absl::StatusOr<std::unique_ptr<BackupRun>> StartBackup() override;
  StoreStats stats() const override;
  absl::Status Close() override { return absl::OkStatus(); }

 private:
  const std::shared_ptr<MemoryDisk> disk_;
  const std::int64_t epoch_;
  mutable std::mutex mutex_;  // guards *disk_
};

}  // namespace cwm::server
