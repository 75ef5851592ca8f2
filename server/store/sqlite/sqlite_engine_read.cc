#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/store/sqlite/sqlite_engine.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

const std::string kSelectSnapshot =
    absl::StrCat("SELECT ", kSnapshotColumns, " FROM snapshot WHERE id = ?");

// The index of the first record above the sequence.
std::size_t IndexAbove(const WorldLog& log, std::int64_t sequence) {
  const auto above = std::upper_bound(
      log.records.begin(), log.records.end(), sequence,
      [](std::int64_t value, const RecordEntry& entry) { return value < entry.sequence; });
  return static_cast<std::size_t>(above - log.records.begin());
}

bool IsObsolete(const StoreIndex& index, const StoredRecord& record) {
  const auto world = index.worlds.find(record.world_uid);
  return world != index.worlds.end() && world->second.snapshot &&
         record.sequence <= world->second.snapshot->sequence;
}

// The record as it was written, by the checksum in the index; else DataLoss.
absl::Status CheckRecord(const StoreIndex& index, const StoredRecord& record) {
  const auto world = index.worlds.find(record.world_uid);
  if (world != index.worlds.end()) {
    const WorldLog& log = world->second;
    const std::size_t above = IndexAbove(log, record.sequence);
    if (above > 0 && log.records[above - 1].sequence == record.sequence &&
        log.records[above - 1].crc == RecordCrc(record, log.ChainBefore(above - 1))) {
      return absl::OkStatus();
    }
  }
  return StoreDamaged(absl::StrCat("record ", record.sequence, " of world ", record.world_uid,
                                   ": is not as it was when the store was opened"));
}

// Records with as many bytes of payload as asked for, one at least.
class Answer {
 public:
  explicit Answer(std::int64_t max_bytes) : max_bytes_(max_bytes) {}
  // False if there is no room for the record.
  bool Add(StoredRecord record) {
    const auto bytes = static_cast<std::int64_t>(record.payload.size());
    if (!records.empty() && bytes_ + bytes > max_bytes_) return false;
    bytes_ += bytes;
    records.push_back(std::move(record));
    return true;
  }

  std::vector<StoredRecord> records;

 private:
  const std::int64_t max_bytes_;
  std::int64_t bytes_ = 0;
};

absl::StatusOr<std::vector<StoredRecord>> ReadWorld(const StoreIndex& index, const WorldLog& log,
                                                    std::int64_t after, std::int64_t max_bytes,
                                                    Statement& row) {
  Answer answer(max_bytes);
  for (std::size_t i = IndexAbove(log, after); i < log.records.size(); ++i) {
    const std::int64_t sequence = log.records[i].sequence;
    row.Reset();
    const absl::StatusOr<bool> is_there = row.Bind(1, sequence).Step();
    if (!is_there.ok()) return is_there.status();
    if (!*is_there) return StoreDamaged(absl::StrCat("record ", sequence, ": cannot be found"));
    StoredRecord record = RecordAt(row);
    if (absl::Status status = CheckRecord(index, record); !status.ok()) return status;
    if (!answer.Add(std::move(record))) break;
  }
  return std::move(answer.records);
}

absl::StatusOr<std::vector<StoredRecord>> ReadAll(const StoreIndex& index, std::int64_t after,
                                                  std::int64_t max_bytes, Statement& rows) {
  Answer answer(max_bytes);
  rows.Reset();
  rows.Bind(1, after);
  std::int64_t end = index.last_sequence;  // of what was read
  for (;;) {
    const absl::StatusOr<bool> has_row = rows.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) break;
    StoredRecord record = RecordAt(rows);
    if (IsObsolete(index, record)) continue;
    if (absl::Status status = CheckRecord(index, record); !status.ok()) return status;
    const std::int64_t sequence = record.sequence;
    if (!answer.Add(std::move(record))) {
      end = sequence - 1;
      break;
    }
  }
  std::size_t expected = 0;
  for (const auto& [world, log] : index.worlds) {
    expected += std::max(IndexAbove(log, end), IndexAbove(log, after)) - IndexAbove(log, after);
  }
  if (expected != answer.records.size()) {
    return StoreDamaged(absl::StrCat("of ", expected, " records after record ", after, " only ",
                                     answer.records.size(), " can be found"));
  }
  return std::move(answer.records);
}

}  // namespace

absl::StatusOr<std::vector<StoredRecord>> SqliteEngine::Follow(std::string_view world_uid,
                                                               std::int64_t after,
                                                               std::int64_t max_bytes) {
  if (absl::Status status = Failure(); !status.ok()) return status;
  absl::StatusOr<std::vector<StoredRecord>> records = std::vector<StoredRecord>();
  if (world_uid.empty()) {
    records = ReadAll(index_, after, max_bytes, read_records_);
    read_records_.Reset();
  } else if (const auto world = index_.worlds.find(world_uid); world != index_.worlds.end()) {
    records = ReadWorld(index_, world->second, after, max_bytes, read_record_);
    read_record_.Reset();
  }
  if (!records.ok()) return Noted(records.status());
  return records;
}

absl::StatusOr<StoredSnapshot> SqliteEngine::ReadSnapshot(std::string_view world_uid,
                                                          const SnapshotEntry& entry,
                                                          Statement& row) {
  row.Reset();
  const absl::StatusOr<bool> is_there = row.Bind(1, entry.row).Step();
  if (!is_there.ok()) return Noted(is_there.status());
  StoredSnapshot snapshot;
  if (*is_there) snapshot = SnapshotAt(row);
  if (!*is_there || snapshot.world_uid != world_uid ||
      SnapshotCrc(snapshot, false, entry.chain) != entry.crc) {
    return StoreDamaged(absl::StrCat("snapshot of world ", std::string(world_uid),
                                     ": is not as it was when the store was opened"));
  }
  return snapshot;
}

absl::StatusOr<std::vector<StoredSnapshot>> SqliteEngine::Snapshots() {
  if (absl::Status status = Failure(); !status.ok()) return status;
  absl::StatusOr<Statement> row = database_.Prepare(kSelectSnapshot);
  if (!row.ok()) return Noted(row.status());
  std::vector<StoredSnapshot> snapshots;
  for (const auto& [world, log] : index_.worlds) {
    if (!log.snapshot || log.snapshot->is_dropped) continue;
    absl::StatusOr<StoredSnapshot> snapshot = ReadSnapshot(world, *log.snapshot, *row);
    if (!snapshot.ok()) return snapshot.status();
    snapshots.push_back(*std::move(snapshot));
  }
  return snapshots;
}

absl::StatusOr<std::optional<StoredSnapshot>> SqliteEngine::SnapshotOf(std::string_view world_uid) {
  if (absl::Status status = Failure(); !status.ok()) return status;
  const auto world = index_.worlds.find(world_uid);
  if (world == index_.worlds.end()) return std::nullopt;
  const std::optional<SnapshotEntry>& entry = world->second.snapshot;
  if (!entry || entry->is_dropped) return std::nullopt;
  absl::StatusOr<Statement> row = database_.Prepare(kSelectSnapshot);
  if (!row.ok()) return Noted(row.status());
  absl::StatusOr<StoredSnapshot> snapshot = ReadSnapshot(world_uid, *entry, *row);
  if (!snapshot.ok()) return snapshot.status();
  return std::optional(*std::move(snapshot));
}

StoreStats SqliteEngine::stats() const {
  StoreStats stats;
  stats.location = absl::StrCat("sqlite:", directory_);
  stats.record_count = record_count_;
  stats.record_bytes = record_bytes_;
  stats.blob_count = blobs_->count();
  stats.bytes = blobs_->bytes();
  for (const char* name : {kDatabaseFile, kLogFile, kHeadFile, kLockFile, kBallastFile}) {
    stats.bytes += FileSize(absl::StrCat(directory_, "/", name));
  }
  return stats;
}

void SqliteEngine::PublishCounts() {
  record_count_ = index_.record_count;
  record_bytes_ = index_.record_bytes;
}

}  // namespace cwm::server
