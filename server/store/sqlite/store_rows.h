// The tables of store.db: what each row is checked by, and what one pass over all rows finds.
//
// CRC-32C guards the rows, because SQLite checks the structure of its pages but not their content.
// The checksum of a record covers its fields and the checksum of its world's record before, so that
// a missing or exchanged row is noticed; a snapshot carries on the checksum of the last record that
// it replaced. The row `meta` counts what was dropped: sequences have no hole but those.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/sqlite_handles.h"
#include "server/store/sqlite/store_files.h"
#include "server/store/store.h"

namespace cwm::server {

// The only row of the table meta.
struct StoreMeta {
  std::string store_uid = {};
  std::int64_t epoch = 0;
  bool is_closed = true;  // by Close, after the last opening
  CacheIdentity cache = {};
  // Losses that Store tells of, until RecoveryDone.
  bool lacks_observed = false;
  bool lacks_durable = false;
  std::int64_t dropped_count = 0;   // records that are no rows any more
  std::int64_t snapshot_count = 0;  // rows, also of dropped worlds
  std::int64_t snapshot_sum = 0;    // of the checksums of all snapshots, modulo 2^32
};

struct RecordEntry {
  std::int64_t sequence = 0;
  std::int64_t bytes = 0;  // of the payload
  std::uint32_t crc = 0;
};

struct SnapshotEntry {
  std::int64_t row = 0;  // its key in the table
  std::int64_t sequence = 0;
  bool is_dropped = false;  // the world has no snapshot, but its records start after the sequence
  std::uint32_t chain = 0;  // checksum of the last record up to the sequence
  std::uint32_t crc = 0;
  std::vector<std::string> blobs = {};
};

struct WorldLog {
  std::optional<SnapshotEntry> snapshot = {};
  std::deque<RecordEntry> records = {};  // by sequence

  // The checksum that the record at the index continues; that of the last for records.size().
  std::uint32_t ChainBefore(std::size_t index) const;
};

// What is in the tables, without the payloads.
struct StoreIndex {
  std::map<std::string, WorldLog, std::less<>> worlds = {};
  std::int64_t last_sequence = 0;
  std::int64_t next_snapshot_row = 1;
  std::int64_t record_count = 0;
  std::int64_t record_bytes = 0;
  std::map<std::int64_t, std::vector<std::string>> record_blobs = {};  // of records that have any
  std::deque<std::int64_t> obsolete = {};  // rows of records that snapshots have replaced

  // Drops the records of a world up to a sequence, into `obsolete`; returns the blobs that they
  // named.
  std::vector<std::string> DropRecords(WorldLog& log, std::int64_t sequence);
};

struct StoreScan {
  StoreMeta meta = {};
  StoreIndex index = {};
  std::int64_t snapshot_bytes = 0;
  // What is not as it was written, in words; records and snapshots that are lost by it.
  std::vector<std::string> faults = {};
  std::vector<std::int64_t> lost_records = {};
  std::vector<std::int64_t> lost_snapshots = {};  // by row
};

// The statements that make the tables of the present version.
extern const char kSchema[];
inline constexpr int kSchemaVersion = 1;

// "1 record", "2 records".
std::string Counted(std::size_t count, std::string_view noun);

std::string JoinHashes(const std::vector<std::string>& hashes);
std::vector<std::string> SplitHashes(std::string_view text);

std::uint32_t RecordCrc(const StoredRecord& record, std::uint32_t chain);
std::uint32_t SnapshotCrc(const StoredSnapshot& snapshot, bool is_dropped, std::uint32_t chain);

// Columns in the order of kRecordColumns and kSnapshotColumns.
inline constexpr char kRecordColumns[] = "sequence, epoch, world, revision, crc, blobs, payload";
StoredRecord RecordAt(const Statement& row);
inline constexpr char kSnapshotColumns[] =
    "id, sequence, world, revision, dropped, chain, crc, blobs, payload";
StoredSnapshot SnapshotAt(const Statement& row);

absl::StatusOr<StoreMeta> ReadMeta(Database& database);
absl::Status WriteMeta(Database& database, const StoreMeta& meta);

// Reads and checks all rows. An error if the tables cannot be read to their ends; faults of rows
// are in the result.
absl::StatusOr<StoreScan> ScanStore(Database& database);

}  // namespace cwm::server
