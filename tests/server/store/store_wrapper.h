// A store that passes everything on to another one: the base of stores that differ in something.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/store.h"

namespace cwm::server {

class StoreWrapper : public Store {
 public:
  explicit StoreWrapper(Store& store) : store_(store) {}

  std::int64_t epoch() const override { return store_.epoch(); }
  std::int64_t last_sequence() const override { return store_.last_sequence(); }
  bool may_lack_observed() const override { return store_.may_lack_observed(); }
  bool may_lack_durable() const override { return store_.may_lack_durable(); }
  absl::Status RecoveryDone() override { return store_.RecoveryDone(); }
  absl::StatusOr<AppendResult> Append(std::span<const StoredRecord> records,
                                      Durability durability) override {
    return store_.Append(records, durability);
  }
  absl::StatusOr<std::vector<StoredRecord>> Follow(std::string_view world_uid, std::int64_t after,
                                                   std::int64_t max_bytes) override {
    return store_.Follow(world_uid, after, max_bytes);
  }
  absl::Status PutSnapshot(const StoredSnapshot& snapshot) override {
    return store_.PutSnapshot(snapshot);
  }
  absl::StatusOr<std::vector<StoredSnapshot>> Snapshots() override { return store_.Snapshots(); }
  absl::StatusOr<std::optional<StoredSnapshot>> SnapshotOf(std::string_view world_uid) override {
    return store_.SnapshotOf(world_uid);
  }
  absl::Status DropWorld(std::string_view world_uid, std::int64_t sequence) override {
    return store_.DropWorld(world_uid, sequence);
  }
  absl::Status PutBlob(const std::string& hash, std::string_view bytes,
                       Durability durability) override {
    return store_.PutBlob(hash, bytes, durability);
  }
  absl::StatusOr<std::string> GetBlob(const std::string& hash) const override {
    return store_.GetBlob(hash);
  }
  bool HasDurableBlob(const std::string& hash) const override {
    return store_.HasDurableBlob(hash);
  }
  absl::Status Maintain() override { return store_.Maintain(); }
  absl::Status CheckRoom() override { return store_.CheckRoom(); }
  absl::StatusOr<std::unique_ptr<BackupRun>> StartBackup() override { return store_.StartBackup(); }
  StoreStats stats() const override { return store_.stats(); }
  absl::Status Close() override { return store_.Close(); }

 private:
  Store& store_;
};

// A store that tells of a loss until its reader says that it has gone on.
class LossyStore final : public StoreWrapper {
 public:
  struct Loss {
    bool observed = false, durable = false;
  };
  LossyStore(Store& store, Loss loss) : StoreWrapper(store), loss_(loss) {}
  bool may_lack_observed() const override { return loss_.observed; }
  bool may_lack_durable() const override { return loss_.durable; }
  absl::Status RecoveryDone() override {
    loss_ = {};
    recovered_at_ = last_sequence();
    return StoreWrapper::RecoveryDone();
  }
  // The sequence of the newest record when the reader had gone on; absent: it has not.
  const std::optional<std::int64_t>& recovered_at() const { return recovered_at_; }

 private:
  Loss loss_;
  std::optional<std::int64_t> recovered_at_ = {};
};

}  // namespace cwm::server
