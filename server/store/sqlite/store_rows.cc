#include "server/store/sqlite/store_rows.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/transfer/crc32c.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

// The bytes that a checksum covers. Texts are preceded by their lengths, so that no two rows have
// the same bytes; large content is covered by its own checksum.
class CheckedBytes {
 public:
  CheckedBytes& Add(std::int64_t number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof(number));
    return *this;
  }
  CheckedBytes& Add(std::string_view text) {
    Add(static_cast<std::int64_t>(text.size()));
    bytes_.append(text);
    return *this;
  }
  CheckedBytes& AddLarge(std::string_view content) {
    Add(static_cast<std::int64_t>(content.size()));
    return Add(static_cast<std::int64_t>(Crc32c(content)));
  }
  std::uint32_t Crc() const { return Crc32c(bytes_); }

 private:
  std::string bytes_;
};

std::uint32_t MetaCrc(const StoreMeta& meta) {
  return CheckedBytes()
      .Add(meta.store_uid)
      .Add(meta.epoch)
      .Add(static_cast<std::int64_t>(meta.is_closed))
      .Add(meta.cache.boot)
      .Add(meta.cache.mount)
      .Add(static_cast<std::int64_t>(meta.lacks_observed))
      .Add(static_cast<std::int64_t>(meta.lacks_durable))
      .Add(meta.dropped_count)
      .Add(meta.snapshot_count)
      .Add(meta.snapshot_sum)
      .Crc();
}

absl::Status ScanSnapshots(Database& database, StoreScan& scan) {
  absl::StatusOr<Statement> rows =
      database.Prepare(absl::StrCat("SELECT ", kSnapshotColumns, " FROM snapshot ORDER BY id"));
  if (!rows.ok()) return rows.status();
  std::int64_t count = 0;
  std::uint32_t sum = 0;
  for (;;) {
    const absl::StatusOr<bool> has_row = rows->Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) break;
    const StoredSnapshot snapshot = SnapshotAt(*rows);
    SnapshotEntry entry = {.row = rows->Int(0),
                           .sequence = snapshot.sequence,
                           .is_dropped = rows->Int(4) != 0,
                           .chain = static_cast<std::uint32_t>(rows->Int(5)),
                           .crc = static_cast<std::uint32_t>(rows->Int(6)),
                           .blobs = snapshot.blobs};
    ++count;
    sum += entry.crc;
    scan.index.next_snapshot_row = std::max(scan.index.next_snapshot_row, entry.row + 1);
    const std::uint32_t crc = SnapshotCrc(snapshot, entry.is_dropped, entry.chain);
    WorldLog& log = scan.index.worlds[snapshot.world_uid];
    if (crc != entry.crc || rows->Int(6) != static_cast<std::int64_t>(crc) ||
        log.snapshot.has_value()) {
      scan.faults.push_back(
          absl::StrCat("snapshot ", entry.row, " of world ", snapshot.world_uid, ": is damaged"));
      scan.lost_snapshots.push_back(entry.row);
      if (!log.snapshot && log.records.empty()) scan.index.worlds.erase(snapshot.world_uid);
      continue;
    }
    scan.snapshot_bytes += static_cast<std::int64_t>(snapshot.payload.size());
    log.snapshot = std::move(entry);
  }
  if (count != scan.meta.snapshot_count || sum != scan.meta.snapshot_sum) {
    scan.faults.push_back(
        absl::StrCat("the snapshots are others than those that were written: ", count,
                     " are there, ", scan.meta.snapshot_count, " were written"));
  }
  return absl::OkStatus();
}

absl::Status ScanRecords(Database& database, StoreScan& scan) {
  absl::StatusOr<Statement> rows =
      database.Prepare(absl::StrCat("SELECT ", kRecordColumns, " FROM record ORDER BY sequence"));
  if (!rows.ok()) return rows.status();
  StoreIndex& index = scan.index;
  std::map<std::string, std::uint32_t, std::less<>> cut;  // worlds that are lost from a record on
  std::int64_t count = 0;
  std::int64_t newest = 0;
  for (;;) {
    const absl::StatusOr<bool> has_row = rows->Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) break;
    StoredRecord record = RecordAt(*rows);
    ++count;
    newest = std::max(newest, record.sequence);
    WorldLog& log = index.worlds[record.world_uid];
    if (log.snapshot && record.sequence <= log.snapshot->sequence) {
      index.obsolete.push_back(record.sequence);
      continue;
    }
    const std::int64_t stored = rows->Int(4);
    const auto is_cut = cut.find(record.world_uid);
    const std::uint32_t chain =
        is_cut == cut.end() ? log.ChainBefore(log.records.size()) : is_cut->second;
    const bool is_as_written = stored == static_cast<std::int64_t>(RecordCrc(record, chain));
    if (!is_as_written) {
      scan.faults.push_back(absl::StrCat("record ", record.sequence, " of world ", record.world_uid,
                                         ": it, or the record of the world "
                                         "before it, is damaged or missing"));
    }
    if (!is_as_written || is_cut != cut.end()) {
      cut[record.world_uid] = static_cast<std::uint32_t>(stored);
      scan.lost_records.push_back(record.sequence);
      continue;
    }
    const auto bytes = static_cast<std::int64_t>(record.payload.size());
    log.records.push_back({record.sequence, bytes, static_cast<std::uint32_t>(stored)});
    ++index.record_count;
    index.record_bytes += bytes;
    if (!record.blobs.empty()) index.record_blobs[record.sequence] = std::move(record.blobs);
  }
  for (const auto& [world, log] : index.worlds) {
    if (log.snapshot) newest = std::max(newest, log.snapshot->sequence);
  }
  index.last_sequence = count + scan.meta.dropped_count;
  if (newest > index.last_sequence) {
    const auto missing = static_cast<std::size_t>(newest - index.last_sequence);
    scan.faults.push_back(absl::StrCat(Counted(missing, "record"), " before record ", newest,
                                       missing == 1 ? " is" : " are", " missing"));
  } else if (newest < index.last_sequence && scan.meta.dropped_count == 0) {
    scan.faults.push_back(absl::StrCat("the table of records has ",
                                       Counted(static_cast<std::size_t>(count), "row"),
                                       " up to record ", newest));
  }
  index.last_sequence = std::max(index.last_sequence, newest);
  return absl::OkStatus();
}

}  // namespace

const char kSchema[] = R"sql(
CREATE TABLE record(
  sequence INTEGER PRIMARY KEY,
  epoch INTEGER NOT NULL,
  world TEXT NOT NULL,
  revision INTEGER NOT NULL,
  crc INTEGER NOT NULL,
  blobs TEXT NOT NULL,
  payload BLOB NOT NULL) STRICT;
CREATE TABLE snapshot(
  id INTEGER PRIMARY KEY,
  sequence INTEGER NOT NULL,
  world TEXT NOT NULL,
  revision INTEGER NOT NULL,
  dropped INTEGER NOT NULL,
  chain INTEGER NOT NULL,
  crc INTEGER NOT NULL,
  blobs TEXT NOT NULL,
  payload BLOB NOT NULL) STRICT;
CREATE TABLE meta(
  id INTEGER PRIMARY KEY,
  store_uid TEXT NOT NULL,
  epoch INTEGER NOT NULL,
  closed INTEGER NOT NULL,
  boot TEXT NOT NULL,
  mount TEXT NOT NULL,
  lacks_observed INTEGER NOT NULL,
  lacks_durable INTEGER NOT NULL,
  dropped_count INTEGER NOT NULL,
  snapshot_count INTEGER NOT NULL,
  snapshot_sum INTEGER NOT NULL,
  crc INTEGER NOT NULL) STRICT;
)sql";

std::uint32_t WorldLog::ChainBefore(std::size_t index) const {
  if (index > 0) return records[index - 1].crc;
  return snapshot ? snapshot->chain : 0;
}

std::vector<std::string> StoreIndex::DropRecords(WorldLog& log, std::int64_t sequence) {
  std::vector<std::string> blobs;
  while (!log.records.empty() && log.records.front().sequence <= sequence) {
    const RecordEntry& entry = log.records.front();
    --record_count;
    record_bytes -= entry.bytes;
    obsolete.push_back(entry.sequence);
    if (auto named = record_blobs.extract(entry.sequence)) {
      blobs.insert(blobs.end(), named.mapped().begin(), named.mapped().end());
    }
    log.records.pop_front();
  }
  return blobs;
}

std::string Counted(std::size_t count, std::string_view noun) {
  return absl::StrCat(count, " ", std::string(noun), count == 1 ? "" : "s");
}

std::string JoinHashes(const std::vector<std::string>& hashes) {
  std::string text;
  for (const std::string& hash : hashes) absl::StrAppend(&text, text.empty() ? "" : " ", hash);
  return text;
}

std::vector<std::string> SplitHashes(std::string_view text) {
  std::vector<std::string> hashes;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    hashes.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return hashes;
}

std::uint32_t RecordCrc(const StoredRecord& record, std::uint32_t chain) {
  return CheckedBytes()
      .Add(static_cast<std::int64_t>(chain))
      .Add(record.sequence)
      .Add(record.epoch)
      .Add(record.world_uid)
      .Add(record.revision)
      .Add(JoinHashes(record.blobs))
      .AddLarge(record.payload)
      .Crc();
}

std::uint32_t SnapshotCrc(const StoredSnapshot& snapshot, bool is_dropped, std::uint32_t chain) {
  return CheckedBytes()
      .Add(static_cast<std::int64_t>(chain))
      .Add(static_cast<std::int64_t>(is_dropped))
      .Add(snapshot.sequence)
      .Add(snapshot.world_uid)
      .Add(snapshot.revision)
      .Add(JoinHashes(snapshot.blobs))
      .AddLarge(snapshot.payload)
      .Crc();
}

StoredRecord RecordAt(const Statement& row) {
  return {.sequence = row.Int(0),
          .epoch = row.Int(1),
          .world_uid = std::string(row.Bytes(2)),
          .revision = row.Int(3),
          .payload = std::string(row.Bytes(6)),
          .blobs = SplitHashes(row.Bytes(5))};
}

StoredSnapshot SnapshotAt(const Statement& row) {
  return {.sequence = row.Int(1),
          .world_uid = std::string(row.Bytes(2)),
          .revision = row.Int(3),
          .payload = std::string(row.Bytes(8)),
          .blobs = SplitHashes(row.Bytes(7))};
}

absl::StatusOr<StoreMeta> ReadMeta(Database& database) {
  absl::StatusOr<Statement> row = database.Prepare(
      "SELECT store_uid, epoch, closed, boot, mount, lacks_observed, lacks_durable, dropped_count, "
      "snapshot_count, snapshot_sum, crc FROM meta WHERE id = 1");
  if (!row.ok()) return row.status();
  const absl::StatusOr<bool> has_row = row->Step();
  if (!has_row.ok()) return has_row.status();
  if (!*has_row) return StoreDamaged("the row of the table meta is missing");
  StoreMeta meta = {.store_uid = std::string(row->Bytes(0)),
                    .epoch = row->Int(1),
                    .is_closed = row->Int(2) != 0,
                    .cache = {std::string(row->Bytes(3)), std::string(row->Bytes(4))},
                    .lacks_observed = row->Int(5) != 0,
                    .lacks_durable = row->Int(6) != 0,
                    .dropped_count = row->Int(7),
                    .snapshot_count = row->Int(8),
                    .snapshot_sum = row->Int(9)};
  if (row->Int(10) != static_cast<std::int64_t>(MetaCrc(meta))) {
    return StoreDamaged("the row of the table meta is damaged");
  }
  return meta;
}

absl::Status WriteMeta(Database& database, const StoreMeta& meta) {
  absl::StatusOr<Statement> row = database.Prepare(
      "INSERT OR REPLACE INTO meta(id, store_uid, epoch, closed, boot, mount, lacks_observed, "
      "lacks_durable, dropped_count, snapshot_count, snapshot_sum, crc) "
      "VALUES (1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!row.ok()) return row.status();
  return row->BindText(1, meta.store_uid)
      .Bind(2, meta.epoch)
      .Bind(3, static_cast<std::int64_t>(meta.is_closed))
      .BindText(4, meta.cache.boot)
      .BindText(5, meta.cache.mount)
      .Bind(6, static_cast<std::int64_t>(meta.lacks_observed))
      .Bind(7, static_cast<std::int64_t>(meta.lacks_durable))
      .Bind(8, meta.dropped_count)
      .Bind(9, meta.snapshot_count)
      .Bind(10, meta.snapshot_sum)
      .Bind(11, MetaCrc(meta))
      .Run();
}

absl::StatusOr<StoreScan> ScanStore(Database& database) {
  StoreScan scan;
  absl::StatusOr<StoreMeta> meta = ReadMeta(database);
  if (!meta.ok()) return meta.status();
  scan.meta = *std::move(meta);
  if (absl::Status status = ScanSnapshots(database, scan); !status.ok()) return status;
  if (absl::Status status = ScanRecords(database, scan); !status.ok()) return status;
  return scan;
}

}  // namespace cwm::server
