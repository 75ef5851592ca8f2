#include "server/store/sqlite/store_salvage.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/store/sqlite/head_file.h"
#include "server/store/sqlite/store_database.h"
#include "server/store/sqlite/store_files.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<std::string> KeepFiles(const std::string& directory,
                                      const std::vector<std::string>& names) {
  std::string kept;
  for (int i = 1;; ++i) {
    kept = absl::StrCat(directory, "/lost-", i);
    if (mkdir(kept.c_str(), 0700) == 0) break;
    if (errno != EEXIST) return FileError(kept, "cannot be created", errno);
  }
  for (const std::string& name : names) {
    std::error_code error;
    fs::copy_file(fs::path(directory) / name, fs::path(kept) / name, error);
    if (error && error.value() != ENOENT) {
      return FileError(absl::StrCat(directory, "/", name), "cannot be copied", error.value());
    }
  }
  return kept;
}

// Copies the rows of a table one by one, by their keys; those that cannot be read are left out.
class RowCopier {
 public:
  RowCopier(Database& from, Database& to) : from_(from), to_(to) {}

  absl::Status CopyRecords(std::int64_t last);
  absl::Status CopySnapshots(std::int64_t last);
  absl::Status WriteCounts();

 private:
  // Steps to the row of a key; false if it is not there or cannot be read.
  static absl::StatusOr<bool> Find(Statement& select, std::int64_t key) {
    select.Reset();
    absl::StatusOr<bool> found = select.Bind(1, key).Step();
    if (found.status().code() == absl::StatusCode::kDataLoss) return false;
    return found;
  }

  Database& from_;
  Database& to_;
  StoreMeta counts_;
  std::int64_t newest_ = 0;
  std::int64_t record_count_ = 0;
};

absl::Status RowCopier::CopyRecords(std::int64_t last) {
  absl::StatusOr<Statement> select =
      from_.Prepare(absl::StrCat("SELECT ", kRecordColumns, " FROM record WHERE sequence = ?"));
  if (!select.ok()) return select.status();
  absl::StatusOr<Statement> insert = to_.Prepare(
      absl::StrCat("INSERT INTO record(", kRecordColumns, ") VALUES (?, ?, ?, ?, ?, ?, ?)"));
  if (!insert.ok()) return insert.status();
  for (std::int64_t sequence = 1; sequence <= last; ++sequence) {
    const absl::StatusOr<bool> found = Find(*select, sequence);
    if (!found.ok()) return found.status();
    if (!*found) continue;
    absl::Status status = insert->Bind(1, sequence)
                              .Bind(2, select->Int(1))
                              .BindText(3, select->Bytes(2))
                              .Bind(4, select->Int(3))
                              .Bind(5, select->Int(4))
                              .BindText(6, select->Bytes(5))
                              .BindBlob(7, select->Bytes(6))
                              .Run();
    if (!status.ok()) return status;
    ++record_count_;
    newest_ = sequence;
    counts_.epoch = std::max(counts_.epoch, select->Int(1));
  }
  return absl::OkStatus();
}

absl::Status RowCopier::CopySnapshots(std::int64_t last) {
  absl::StatusOr<Statement> select =
      from_.Prepare(absl::StrCat("SELECT ", kSnapshotColumns, " FROM snapshot WHERE id = ?"));
  if (!select.ok()) return select.status();
  absl::StatusOr<Statement> insert = to_.Prepare(absl::StrCat(
      "INSERT INTO snapshot(", kSnapshotColumns, ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  if (!insert.ok()) return insert.status();
  std::uint32_t sum = 0;
  for (std::int64_t id = 1; id <= last; ++id) {
    const absl::StatusOr<bool> found = Find(*select, id);
    if (!found.ok()) return found.status();
    if (!*found) continue;
    absl::Status status = insert->Bind(1, id)
                              .Bind(2, select->Int(1))
                              .BindText(3, select->Bytes(2))
                              .Bind(4, select->Int(3))
                              .Bind(5, select->Int(4))
                              .Bind(6, select->Int(5))
                              .Bind(7, select->Int(6))
                              .BindText(8, select->Bytes(7))
                              .BindBlob(9, select->Bytes(8))
                              .Run();
    if (!status.ok()) return status;
    ++counts_.snapshot_count;
    sum += static_cast<std::uint32_t>(select->Int(6));
    newest_ = std::max(newest_, select->Int(1));
  }
  counts_.snapshot_sum = sum;
  return absl::OkStatus();
}

absl::Status RowCopier::WriteCounts() {
  const absl::StatusOr<StoreMeta> old = ReadMeta(from_);
  StoreMeta meta = counts_;
  meta.store_uid = old.ok() ? old->store_uid : NewStoreUid();
  if (old.ok()) {
    meta.epoch = std::max(meta.epoch, old->epoch);
    meta.is_closed = old->is_closed;
    meta.cache = old->cache;
    meta.lacks_observed = old->lacks_observed;
  }
  meta.lacks_durable = true;
  meta.dropped_count = newest_ - record_count_;
  return WriteMeta(to_, meta);
}

}  // namespace

absl::StatusOr<std::string> DropLost(Database& database, const std::string& directory,
                                     StoreScan& scan) {
  std::vector<std::string> names = {kLogFile, kHeadFile};
  const bool rows_are_lost = !scan.lost_records.empty() || !scan.lost_snapshots.empty();
  if (rows_are_lost) names.emplace_back(kDatabaseFile);
  absl::StatusOr<std::string> kept = KeepFiles(directory, names);
  if (!kept.ok()) return kept;
  absl::StatusOr<Transaction> transaction = Transaction::Begin(database);
  if (!transaction.ok()) return transaction.status();
  for (const std::int64_t sequence : scan.lost_records) {
    const std::string sql = absl::StrCat("DELETE FROM record WHERE sequence = ", sequence);
    if (absl::Status status = database.Execute(sql); !status.ok()) return status;
  }
  for (const std::int64_t row : scan.lost_snapshots) {
    const std::string sql = absl::StrCat("DELETE FROM snapshot WHERE id = ", row);
    if (absl::Status status = database.Execute(sql); !status.ok()) return status;
  }
  const absl::StatusOr<std::int64_t> rows = database.Int("SELECT count(*) FROM record");
  if (!rows.ok()) return rows.status();
  scan.meta.dropped_count = scan.index.last_sequence - *rows;
  const absl::StatusOr<std::int64_t> snapshots = database.Int("SELECT count(*) FROM snapshot");
  if (!snapshots.ok()) return snapshots.status();
  scan.meta.snapshot_count = *snapshots;
  std::uint32_t sum = 0;
  for (const auto& [world, log] : scan.index.worlds) {
    if (log.snapshot) sum += log.snapshot->crc;
  }
  scan.meta.snapshot_sum = sum;
  scan.meta.lacks_durable = true;
  if (absl::Status status = WriteMeta(database, scan.meta); !status.ok()) return status;
  if (absl::Status status = transaction->Commit(); !status.ok()) return status;
  scan.faults.clear();
  return kept;
}

absl::StatusOr<std::string> Rebuild(Database& database, const std::string& directory) {
  const absl::StatusOr<Head> head = ReadHead(absl::StrCat(directory, "/", kHeadFile));
  const absl::StatusOr<std::int64_t> newest =
      database.Int("SELECT ifnull(max(sequence), 0) FROM record");
  if (!head.ok() && !newest.ok()) return newest.status();
  const absl::StatusOr<std::int64_t> snapshots =
      database.Int("SELECT ifnull(max(id), 0) FROM snapshot");
  if (!snapshots.ok()) return snapshots.status();

  const std::string path = absl::StrCat(directory, "/", kDatabaseFile);
  absl::StatusOr<std::string> kept = KeepFiles(directory, {kLogFile, kHeadFile, kDatabaseFile});
  if (!kept.ok()) return kept;
  const std::string unfinished = absl::StrCat(directory, "/", kNewDatabaseFile);
  unlink(unfinished.c_str());
  if (absl::Status status = WriteTables(unfinished); !status.ok()) return status;
  absl::StatusOr<Database> copy = Database::Open(unfinished, false);
  if (!copy.ok()) return copy.status();
  {
    absl::StatusOr<Transaction> transaction = Transaction::Begin(*copy);
    if (!transaction.ok()) return transaction.status();
    RowCopier copier(database, *copy);
    absl::Status status =
        copier.CopyRecords(std::max(head.ok() ? head->last : 0, newest.ok() ? *newest : 0));
    if (status.ok()) status = copier.CopySnapshots(*snapshots);
    if (status.ok()) status = copier.WriteCounts();
    if (status.ok()) status = transaction->Commit();
    if (!status.ok()) return status;
  }
  copy = Database();
  database = {};
  // Without the old log first: it does not belong to the new database.
  unlink(absl::StrCat(directory, "/", kLogFile).c_str());
  if (rename(unfinished.c_str(), path.c_str()) != 0) {
    return FileError(path, "cannot be replaced", errno);
  }
  if (absl::Status status = SyncFile(directory); !status.ok()) return status;
  return kept;
}

}  // namespace cwm::server
