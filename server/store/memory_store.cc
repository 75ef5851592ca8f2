#include "server/store/memory_store.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "absl/strings/str_cat.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

class MemoryBackup final : public Backup {
 public:
  MemoryBackup(fs::path folder, const MemoryDisk& disk)
      : folder_(std::move(folder)), sequence_(disk.last_sequence) {
    std::string text;
    const auto add = [&text](std::int64_t sequence, const std::string& world, std::int64_t revision,
                             const std::string& payload) {
      absl::StrAppend(&text, sequence, " ", world, " ", revision, " ", payload.size(), "\n",
                      payload, "\n");
    };
    for (const auto& [world, snapshot] : disk.snapshots) {
      add(snapshot.sequence, world, snapshot.revision, snapshot.payload);
    }
    for (const auto& [sequence, record] : disk.records) {
      add(sequence, record.world_uid, record.revision, record.payload);
    }
    Write("records", text);
    for (const auto& [hash, bytes] : disk.blobs) Write(hash, bytes);
  }
  ~MemoryBackup() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  MemoryBackup(const MemoryBackup&) = delete;
  MemoryBackup& operator=(const MemoryBackup&) = delete;

  const std::vector<BackupFile>& files() const override { return files_; }
  std::int64_t sequence() const override { return sequence_; }

 private:
  void Write(const std::string& name, std::string_view bytes) {
    const fs::path source = folder_ / name;
    std::ofstream out(source, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    files_.push_back({name, source.string()});
  }

  const fs::path folder_;
  const std::int64_t sequence_;
  std::vector<BackupFile> files_;
};

class MemoryBackupRun final : public Store::BackupRun {
 public:
  explicit MemoryBackupRun(MemoryDisk disk) : disk_(std::move(disk)) {}
  absl::StatusOr<std::unique_ptr<Backup>> Step() override {
    static std::atomic<int> count = 0;
    fs::path folder =
        fs::temp_directory_path() / absl::StrCat("cwm-backup-", getpid(), "-", ++count);
    std::error_code error;
    fs::create_directory(folder, error);
    if (error) {
      return absl::InternalError(
          absl::StrCat("cannot create ", folder.string(), ": ", error.message()));
    }
    return std::make_unique<MemoryBackup>(std::move(folder), disk_);
  }

 private:
  const MemoryDisk disk_;
};

}  // namespace

MemoryStore::MemoryStore(std::shared_ptr<MemoryDisk> disk)
    : disk_(std::move(disk)), epoch_(++disk_->epoch) {}

std::int64_t MemoryStore::last_sequence() const {
  const std::scoped_lock lock(mutex_);
  return disk_->last_sequence;
}

absl::StatusOr<AppendResult> MemoryStore::Append(std::span<const StoredRecord> records,
                                                 Durability /*durability*/) {
  const std::scoped_lock lock(mutex_);
  if (absl::Status status = CheckRecords(records, disk_->last_sequence); !status.ok()) {
    return status;
  }
  if (!records.empty() && records.front().sequence <= disk_->last_sequence) {
    return AppendResult::kSuperseded;
  }
  for (const StoredRecord& record : records) {
    disk_->records.emplace(record.sequence, record);
    disk_->last_sequence = record.sequence;
  }
  return AppendResult::kDurable;
}

absl::StatusOr<std::vector<StoredRecord>> MemoryStore::Follow(std::string_view world_uid,
                                                              std::int64_t after,
                                                              std::int64_t max_bytes) {
  const std::scoped_lock lock(mutex_);
  std::vector<StoredRecord> followed;
  std::int64_t bytes = 0;
  for (auto it = disk_->records.upper_bound(after); it != disk_->records.end(); ++it) {
    const StoredRecord& record = it->second;
    if (!world_uid.empty() && record.world_uid != world_uid) continue;
    bytes += static_cast<std::int64_t>(record.payload.size());
    if (!followed.empty() && bytes > max_bytes) break;
    followed.push_back(record);
  }
  return followed;
}

absl::Status MemoryStore::PutSnapshot(const StoredSnapshot& snapshot) {
  const std::scoped_lock lock(mutex_);
  const auto before = disk_->snapshots.find(snapshot.world_uid);
  const std::int64_t earliest = before == disk_->snapshots.end() ? 0 : before->second.sequence;
  if (absl::Status status = CheckSnapshot(snapshot, earliest, disk_->last_sequence); !status.ok()) {
    return status;
  }
  disk_->snapshots[snapshot.world_uid] = snapshot;
  std::erase_if(disk_->records, [&](const auto& entry) {
    return entry.first <= snapshot.sequence && entry.second.world_uid == snapshot.world_uid;
  });
  return absl::OkStatus();
}

absl::StatusOr<std::optional<StoredSnapshot>> MemoryStore::SnapshotOf(std::string_view world_uid) {
  const std::lock_guard lock(mutex_);
  const auto found = disk_->snapshots.find(world_uid);
  if (found == disk_->snapshots.end()) return std::nullopt;
  return std::optional(found->second);
}

bool MemoryStore::HasDurableBlob(const std::string& hash) const {
  const std::lock_guard lock(mutex_);
  return disk_->blobs.contains(hash);
}

absl::StatusOr<std::vector<StoredSnapshot>> MemoryStore::Snapshots() {
  const std::scoped_lock lock(mutex_);
  std::vector<StoredSnapshot> snapshots;
  for (const auto& [world, snapshot] : disk_->snapshots) snapshots.push_back(snapshot);
  return snapshots;
}

absl::Status MemoryStore::DropWorld(std::string_view world_uid, std::int64_t sequence) {
  const std::scoped_lock lock(mutex_);
  const auto snapshot = disk_->snapshots.find(world_uid);
  if (snapshot != disk_->snapshots.end()) disk_->snapshots.erase(snapshot);
  std::erase_if(disk_->records, [&](const auto& entry) {
    return entry.first <= sequence && entry.second.world_uid == world_uid;
  });
  return absl::OkStatus();
}

absl::Status MemoryStore::PutBlob(const std::string& hash, std::string_view bytes,
                                  Durability /*durability*/) {
  if (absl::Status status = CheckBlobHash(hash); !status.ok()) return status;
  const std::scoped_lock lock(mutex_);
  disk_->blobs[hash] = std::string(bytes);
  return absl::OkStatus();
}

absl::StatusOr<std::string> MemoryStore::GetBlob(const std::string& hash) const {
  const std::scoped_lock lock(mutex_);
  const auto blob = disk_->blobs.find(hash);
  if (blob == disk_->blobs.end()) return BlobMissing(hash);
  if (absl::Status status = CheckBlobBytes(hash, blob->second); !status.ok()) return status;
  return blob->second;
}

absl::StatusOr<std::unique_ptr<Store::BackupRun>> MemoryStore::StartBackup() {
  const std::scoped_lock lock(mutex_);
  return std::make_unique<MemoryBackupRun>(*disk_);
}

StoreStats MemoryStore::stats() const {
  const std::scoped_lock lock(mutex_);
  StoreStats stats;
  stats.location = "memory";
  stats.record_count = static_cast<std::int64_t>(disk_->records.size());
  for (const auto& [sequence, record] : disk_->records) {
    stats.record_bytes += static_cast<std::int64_t>(record.payload.size());
  }
  stats.bytes = stats.record_bytes;
  for (const auto& [hash, bytes] : disk_->blobs) {
    stats.bytes += static_cast<std::int64_t>(bytes.size());
  }
  for (const auto& [world, snapshot] : disk_->snapshots) {
    stats.bytes += static_cast<std::int64_t>(snapshot.payload.size());
  }
  stats.blob_count = static_cast<std::int64_t>(disk_->blobs.size());
  return stats;
}

}  // namespace cwm::server
