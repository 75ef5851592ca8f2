#include <sqlite3.h>

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/core/failpoint.h"
#include "server/store/sqlite/sqlite_engine.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

using std::chrono::steady_clock;

constexpr int kMaxLogPages = 1024;  // 4 MiB; chosen: tens of milliseconds to move
// The file of the log is shortened when it is longer, as after a large snapshot.
constexpr std::int64_t kMaxLogBytes = std::int64_t{64} << 20;
constexpr auto kIdle = std::chrono::seconds(1);   // without an append, before a short log is moved
constexpr std::size_t kRowsPerTransaction = 500;  // chosen: a few milliseconds
constexpr auto kMaxDeletionTime = std::chrono::milliseconds(20);  // in one Maintain; chosen
constexpr int kMaxBlobsPerMaintain = 256;                         // chosen: a few milliseconds

}  // namespace

absl::Status SqliteEngine::Maintain() {
  if (absl::Status status = Failure(); !status.ok()) return status;
  absl::Status status;
  const steady_clock::time_point start = steady_clock::now();
  while (!index_.obsolete.empty() && steady_clock::now() - start < kMaxDeletionTime) {
    if (status = DeleteObsolete(); !status.ok()) return status;
  }
  if (index_.obsolete.empty()) status = DeleteDropped();
  if (!status.ok()) return status;
  const bool is_idle = start - last_append_ > kIdle;
  const std::int64_t log_bytes = FileSize(absl::StrCat(directory_, "/", kLogFile));
  const bool may_make_room = log_bytes > 0 && RoomBytes() < options_.low_water_bytes;
  if (log_pages_ >= kMaxLogPages || (is_idle && (log_pages_ > 0 || may_make_room))) {
    const absl::StatusOr<bool> moved =
        Checkpoint(is_idle && (log_bytes > kMaxLogBytes || may_make_room));
    if (!moved.ok()) return moved.status();
  }
  if (status = RemoveUnusedBlobs(options_.blob_grace); !status.ok()) return status;
  if (!ballast_.exists() && RoomBytes() >= options_.low_water_bytes) ballast_.Restore();
  return absl::OkStatus();
}

absl::Status SqliteEngine::DeleteObsolete() {
  const std::size_t count = std::min(index_.obsolete.size(), kRowsPerTransaction);
  StoreMeta meta = meta_;
  meta.dropped_count += static_cast<std::int64_t>(count);
  absl::Status status = WithBallast([&] {
    return InTransaction(Durability::kObserved, [&] {
      for (std::size_t i = 0; i < count; ++i) {
        absl::Status deleted = delete_record_.Bind(1, index_.obsolete[i]).Run();
        if (!deleted.ok()) return deleted;
      }
      FailPoint("compaction");
      return WriteMeta(database_, meta);
    });
  });
  if (!status.ok()) return status;
  meta_ = meta;
  index_.obsolete.erase(index_.obsolete.begin(),
                        index_.obsolete.begin() + static_cast<std::ptrdiff_t>(count));
  return absl::OkStatus();
}

// Once no row is obsolete, the marks of dropped worlds are of no use, but for worlds with records
// behind them.
absl::Status SqliteEngine::DeleteDropped() {
  std::vector<std::string> worlds;
  std::vector<std::int64_t> rows;
  StoreMeta meta = meta_;
  for (const auto& [world, log] : index_.worlds) {
    if (!log.records.empty()) continue;
    if (log.snapshot && !log.snapshot->is_dropped) continue;
    worlds.push_back(world);
    if (!log.snapshot) continue;
    rows.push_back(log.snapshot->row);
    --meta.snapshot_count;
    meta.snapshot_sum = static_cast<std::uint32_t>(meta.snapshot_sum - log.snapshot->crc);
  }
  if (worlds.empty()) return absl::OkStatus();
  absl::Status status = WithBallast([&] {
    return InTransaction(Durability::kObserved, [&] {
      for (const std::int64_t row : rows) {
        absl::Status deleted =
            database_.Execute(absl::StrCat("DELETE FROM snapshot WHERE id = ", row));
        if (!deleted.ok()) return deleted;
      }
      return WriteMeta(database_, meta);
    });
  });
  if (!status.ok()) return status;
  meta_ = meta;
  for (const std::string& world : worlds) index_.worlds.erase(world);
  return absl::OkStatus();
}

absl::StatusOr<bool> SqliteEngine::Checkpoint(bool truncate) {
  if (absl::Status status = Failure(); !status.ok()) return status;
  FailPoint("checkpoint");
  int log_pages = 0;
  int moved_pages = 0;
  absl::Status status = WithBallast([&] {
    const int code = sqlite3_wal_checkpoint_v2(
        database_.get(), "main", truncate ? SQLITE_CHECKPOINT_TRUNCATE : SQLITE_CHECKPOINT_PASSIVE,
        &log_pages, &moved_pages);
    return database_.StatusOf(code);
  });
  if (!status.ok()) return Noted(status);
  FailPoint("checkpoint");
  const bool moved_all = log_pages == moved_pages;
  if (moved_all) log_pages_ = 0;
  return moved_all;
}

absl::Status SqliteEngine::RemoveUnusedBlobs(steady_clock::duration grace) {
  if (!blobs_->HasUnused(grace)) return absl::OkStatus();
  // What dropped their last uses must not come back in a power cut.
  const absl::StatusOr<bool> moved = Checkpoint(false);
  if (!moved.ok()) return moved.status();
  if (*moved) blobs_->RemoveUnused(grace, kMaxBlobsPerMaintain);
  return absl::OkStatus();
}

std::int64_t SqliteEngine::RoomBytes() const {
  return FreeBytes(directory_) - (ballast_.exists() ? 0 : ballast_.bytes());
}

absl::Status SqliteEngine::CheckRoom() {
  if (absl::Status status = Failure(); !status.ok()) return status;
  if (RoomBytes() >= options_.low_water_bytes) return absl::OkStatus();
  if (FileSize(absl::StrCat(directory_, "/", kLogFile)) > 0) {
    const absl::StatusOr<bool> moved = Checkpoint(true);
    if (!moved.ok()) return moved.status();
  }
  if (absl::Status status = RemoveUnusedBlobs(options_.blob_grace); !status.ok()) return status;
  return CheckRoomFor(0);
}

absl::Status SqliteEngine::CheckRoomFor(std::int64_t bytes) const {
  const std::int64_t room = RoomBytes();
  const std::int64_t needed = options_.low_water_bytes + bytes;
  if (room >= needed) return absl::OkStatus();
  constexpr std::int64_t kMebi = std::int64_t{1} << 20;
  return DiskFull(absl::StrCat(directory_, ": the disk has ",
                               std::max<std::int64_t>(room, 0) / kMebi,
                               " MiB left for the store, must have ", (needed + kMebi - 1) / kMebi,
                               "; changes are refused until there is room"));
}

}  // namespace cwm::server
