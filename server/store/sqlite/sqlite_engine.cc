#include "server/store/sqlite/sqlite_engine.h"

#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/failpoint.h"
#include "server/store/sqlite/sqlite_backup.h"
#include "server/store/sqlite/store_database.h"
#include "server/store/sqlite/store_salvage.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

using std::chrono::steady_clock;

// Larger databases are read and checked row by row all the same. derived: 0.2 s at 300 MB/s.
constexpr std::int64_t kMaxPageCheckBytes = std::int64_t{64} << 20;

constexpr char kAdvice[] =
    "; restore a backup into another directory, or accept the loss (--store-accept-loss)";

int CountLogPages(void* pages, sqlite3* /*database*/, const char* /*name*/, int count) {
  *static_cast<int*>(pages) = count;
  return SQLITE_OK;
}

absl::Status MakeDirectory(const std::string& directory) {
  if (mkdir(directory.c_str(), 0700) == 0 || errno == EEXIST) return absl::OkStatus();
  return FileError(directory, "cannot be created", errno);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> OpenSqliteStore(const SqliteOptions& options) {
  return SqliteEngine::Open(options);
}

absl::StatusOr<std::unique_ptr<Store>> SqliteEngine::Open(const SqliteOptions& given) {
  SqliteOptions options = given;
  if (options.path.empty()) return InvalidField("path", "is empty, must name a directory");
  options.path = AbsolutePath(options.path);

  const absl::StatusOr<DirectoryContent> before = InspectDirectory(options.path);
  if (!before.ok()) return before.status();
  if (absl::Status status = MakeDirectory(options.path); !status.ok()) return status;
  std::string warning;
  absl::Status status = CheckFileSystem(options.path, options.allow_network_mount, warning);
  if (!status.ok()) return status;
  if (!warning.empty() && options.warn) options.warn(warning);
  absl::StatusOr<FileDescriptor> lock = LockDirectory(options.path);
  if (!lock.ok()) return lock.status();
  RemoveLeftovers(options.path);
  const absl::StatusOr<DirectoryContent> content = InspectDirectory(options.path);
  if (!content.ok()) return content.status();
  if (*content == DirectoryContent::kNothing) {
    if (status = CreateStore(options.path); !status.ok()) return status;
  }
  std::unique_ptr<SqliteEngine> engine(new SqliteEngine(options, *std::move(lock)));
  if (status = engine->Load(); !status.ok()) return status;
  return engine;
}

SqliteEngine::SqliteEngine(const SqliteOptions& options, FileDescriptor lock)
    : options_(options),
      directory_(options.path),
      lock_(std::move(lock)),
      ballast_(absl::StrCat(directory_, "/", kBallastFile), options.ballast_bytes) {}

SqliteEngine::~SqliteEngine() {
  if (backup_run_ != nullptr) backup_run_->Abandon();
}

absl::Status SqliteEngine::Load() {
  absl::Status status = OpenDatabase();
  if (!status.ok()) return status;
  status = Migrate(database_, directory_, options_.migrations);
  if (!status.ok()) return status;
  if (status = LoadRows(); !status.ok()) return status;

  absl::StatusOr<std::unique_ptr<BlobFiles>> blobs = BlobFiles::Open(directory_);
  if (!blobs.ok()) return blobs.status();
  blobs_ = *std::move(blobs);
  for (const auto& [sequence, hashes] : index_.record_blobs) blobs_->AddUses(hashes);
  for (const auto& [world, log] : index_.worlds) {
    if (log.snapshot) blobs_->AddUses(log.snapshot->blobs);
  }
  if (status = PrepareStatements(); !status.ok()) return status;
  if (status = BeginEpoch(); !status.ok()) return status;
  if (RoomBytes() >= options_.low_water_bytes) ballast_.Restore();
  PublishCounts();
  return absl::OkStatus();
}

absl::Status SqliteEngine::OpenDatabase() {
  absl::StatusOr<Database> database =
      OpenStoreDatabase(directory_, DatabaseUse::kWrite, options_.vfs);
  if (!database.ok()) return database.status();
  database_ = *std::move(database);
  sqlite3_wal_hook(database_.get(), CountLogPages, &log_pages_);
  return absl::OkStatus();
}

absl::Status SqliteEngine::LoadRows() {
  const bool check_pages =
      FileSize(absl::StrCat(directory_, "/", kDatabaseFile)) <= kMaxPageCheckBytes;
  absl::StatusOr<StoreScan> scan = ReadWholeStore(database_, directory_, check_pages);
  if (scan.status().code() == absl::StatusCode::kDataLoss && options_.accept_loss) {
    const absl::StatusOr<std::string> kept = Rebuild(database_, directory_);
    if (!kept.ok()) return kept.status();
    Warn(absl::StrCat(
        "goes on with the rows that can be read: ", std::string(scan.status().message()),
        "; the files as they were are in ", *kept));
    if (absl::Status status = OpenDatabase(); !status.ok()) return status;
    scan = ReadWholeStore(database_, directory_, true);
  }
  if (!scan.ok()) {
    if (scan.status().code() != absl::StatusCode::kDataLoss) return scan.status();
    return StoreDamaged(absl::StrCat(Located(std::string(scan.status().message())), kAdvice));
  }
  if (!scan->faults.empty()) {
    const std::string fault = scan->faults.front();
    if (!options_.accept_loss) {
      return StoreDamaged(
          absl::StrCat(Located(fault), " (faults found: ", scan->faults.size(), ")", kAdvice));
    }
    const absl::StatusOr<std::string> kept = DropLost(database_, directory_, *scan);
    if (!kept.ok()) return kept.status();
    Warn(absl::StrCat("goes on without what is lost: ", fault, "; dropped are ",
                      Counted(scan->lost_records.size(), "record"), " and ",
                      Counted(scan->lost_snapshots.size(), "snapshot"),
                      "; the files as they were are in ", *kept));
  }
  meta_ = std::move(scan->meta);
  index_ = std::move(scan->index);
  return absl::OkStatus();
}

std::string SqliteEngine::Located(const std::string& text) const {
  return text.starts_with(directory_) ? text : absl::StrCat(directory_, ": ", text);
}

void SqliteEngine::Warn(const std::string& text) const {
  if (options_.warn) options_.warn(absl::StrCat(directory_, ": ", text));
}

absl::Status SqliteEngine::PrepareStatements() {
  const auto prepare = [this](Statement& statement, const std::string& sql) -> absl::Status {
    absl::StatusOr<Statement> prepared = database_.Prepare(sql);
    if (!prepared.ok()) return prepared.status();
    statement = *std::move(prepared);
    return absl::OkStatus();
  };
  absl::Status status = prepare(insert_record_, absl::StrCat("INSERT INTO record(", kRecordColumns,
                                                             ") VALUES (?, ?, ?, ?, ?, ?, ?)"));
  status.Update(prepare(read_records_, absl::StrCat("SELECT ", kRecordColumns,
                                                    " FROM record WHERE sequence > ? "
                                                    "ORDER BY sequence")));
  status.Update(prepare(
      read_record_, absl::StrCat("SELECT ", kRecordColumns, " FROM record WHERE sequence = ?")));
  status.Update(prepare(delete_record_, "DELETE FROM record WHERE sequence = ?"));
  return status;
}

// What was recovered is moved into the database and synced before anyone sees it: a process that
// was killed may have left it in the memory of the system alone.
absl::Status SqliteEngine::BeginEpoch() {
  CacheIdentity cache = CurrentCache(directory_);
  StoreMeta meta = meta_;
  meta.epoch += 1;
  // The next opening compares with the present cache, and would not see this loss.
  meta.lacks_observed |= !meta_.is_closed && meta_.cache != cache;
  meta.is_closed = false;
  meta.cache = std::move(cache);
  absl::Status status = WithBallast([&] {
    return InTransaction(Durability::kDurable, [&] { return WriteMeta(database_, meta); });
  });
  if (!status.ok()) return status;
  meta_ = std::move(meta);
  const absl::StatusOr<bool> moved = Checkpoint(true);
  if (!moved.ok()) return moved.status();
  absl::StatusOr<HeadFile> head = HeadFile::Open(absl::StrCat(directory_, "/", kHeadFile));
  if (!head.ok()) return head.status();
  head_file_ = *std::move(head);
  head_ = {.last = index_.last_sequence, .durable = index_.last_sequence};
  if (status = head_file_.Write(head_); !status.ok()) return Noted(status);
  return Noted(head_file_.Sync());
}

absl::Status SqliteEngine::RecoveryDone() {
  if (absl::Status status = Failure(); !status.ok()) return status;
  if (!meta_.lacks_observed && !meta_.lacks_durable) return absl::OkStatus();
  StoreMeta meta = meta_;
  meta.lacks_observed = false;
  meta.lacks_durable = false;
  absl::Status status = WithBallast([&] {
    return InTransaction(Durability::kDurable, [&] { return WriteMeta(database_, meta); });
  });
  if (status.ok()) meta_ = std::move(meta);
  return status;
}

absl::Status SqliteEngine::Noted(absl::Status status) {
  if (status.code() == absl::StatusCode::kUnavailable) failed_ = status;
  return status;
}

absl::Status SqliteEngine::NotedAnywhere(absl::Status status) const {
  if (status.code() != absl::StatusCode::kUnavailable) return status;
  const std::scoped_lock lock(blob_mutex_);
  blob_failure_ = status;
  blobs_have_failed_ = true;
  return status;
}

absl::Status SqliteEngine::Failure() const {
  if (!failed_.ok() || !blobs_have_failed_) return failed_;
  const std::scoped_lock lock(blob_mutex_);
  return blob_failure_;
}

absl::Status SqliteEngine::SetSynchronous(Durability durability) {
  if (synchronous_ == durability) return absl::OkStatus();
  absl::Status status =
      database_.Execute(durability == Durability::kDurable ? "PRAGMA synchronous = FULL"
                                                           : "PRAGMA synchronous = NORMAL");
  if (status.ok()) synchronous_ = durability;
  return status;
}

absl::Status SqliteEngine::InTransaction(Durability durability,
                                         const std::function<absl::Status()>& work) {
  if (absl::Status status = Failure(); !status.ok()) return status;
  if (absl::Status status = SetSynchronous(durability); !status.ok()) return Noted(status);
  absl::StatusOr<Transaction> transaction = Transaction::Begin(database_);
  if (!transaction.ok()) return Noted(transaction.status());
  if (absl::Status status = work(); !status.ok()) return Noted(status);
  return Noted(transaction->Commit());
}

absl::Status SqliteEngine::WithBallast(const std::function<absl::Status()>& work) {
  absl::Status status = work();
  if (DetailsOf(status).reason != "DISK_FULL" || !ballast_.exists()) return status;
  ballast_.Remove();
  return work();
}

absl::StatusOr<AppendResult> SqliteEngine::Append(std::span<const StoredRecord> records,
                                                  Durability durability) {
  if (absl::Status status = Failure(); !status.ok()) return status;
  const std::int64_t last = index_.last_sequence;
  if (absl::Status status = CheckRecords(records, last); !status.ok()) return status;
  if (records.empty()) return AppendResult::kDurable;
  if (records.front().sequence <= last) return AppendResult::kSuperseded;
  FailPoint("before-record");
  std::vector<std::uint32_t> crcs;
  crcs.reserve(records.size());
  std::map<std::string_view, std::uint32_t> chains;
  for (const StoredRecord& record : records) {
    const auto [chain, is_first] = chains.try_emplace(record.world_uid, 0);
    if (is_first) {
      const auto log = index_.worlds.find(record.world_uid);
      if (log != index_.worlds.end()) {
        chain->second = log->second.ChainBefore(log->second.records.size());
      }
    }
    chain->second = RecordCrc(record, chain->second);
    crcs.push_back(chain->second);
  }
  const auto insert = [&] {
    for (std::size_t i = 0; i < records.size(); ++i) {
      const StoredRecord& record = records[i];
      const std::string blobs = JoinHashes(record.blobs);
      absl::Status inserted = insert_record_.Bind(1, record.sequence)
                                  .Bind(2, record.epoch)
                                  .BindText(3, record.world_uid)
                                  .Bind(4, record.revision)
                                  .Bind(5, crcs[i])
                                  .BindText(6, blobs)
                                  .BindBlob(7, record.payload)
                                  .Run();
      if (!inserted.ok()) return inserted;
    }
    return absl::OkStatus();
  };
  // CheckRoom has refused what may wait; what comes all the same frees memory or room.
  absl::Status status = WithBallast([&] { return InTransaction(durability, insert); });
  if (!status.ok()) return status;
  FailPoint("after-commit");
  for (std::size_t i = 0; i < records.size(); ++i) {
    const StoredRecord& record = records[i];
    const auto bytes = static_cast<std::int64_t>(record.payload.size());
    index_.worlds[record.world_uid].records.push_back({record.sequence, bytes, crcs[i]});
    ++index_.record_count;
    index_.record_bytes += bytes;
    if (!record.blobs.empty()) index_.record_blobs[record.sequence] = record.blobs;
    blobs_->AddUses(record.blobs);
  }
  index_.last_sequence = records.back().sequence;
  last_append_ = steady_clock::now();
  head_.last = index_.last_sequence;
  if (durability == Durability::kDurable) head_.durable = index_.last_sequence;
  // The head only helps to notice damage later; a failing disk fails the next transaction.
  (void)head_file_.Write(head_);
  PublishCounts();
  return AppendResult::kDurable;
}

absl::Status SqliteEngine::PutSnapshot(const StoredSnapshot& snapshot) {
  const auto world = index_.worlds.find(snapshot.world_uid);
  const bool had_snapshot = world != index_.worlds.end() && world->second.snapshot.has_value();
  const std::int64_t earliest = had_snapshot ? world->second.snapshot->sequence : 0;
  absl::Status status = CheckSnapshot(snapshot, earliest, index_.last_sequence);
  if (!status.ok()) return status;
  return ReplaceSnapshot(snapshot, false);
}

absl::Status SqliteEngine::DropWorld(std::string_view world_uid, std::int64_t sequence) {
  const auto world = index_.worlds.find(world_uid);
  if (world == index_.worlds.end()) return absl::OkStatus();
  StoredSnapshot end = {.sequence = std::min(sequence, index_.last_sequence),
                        .world_uid = std::string(world_uid)};
  const std::optional<SnapshotEntry>& snapshot = world->second.snapshot;
  if (snapshot) end.sequence = std::max(end.sequence, snapshot->sequence);
  return ReplaceSnapshot(end, true);
}

absl::Status SqliteEngine::ReplaceSnapshot(const StoredSnapshot& snapshot, bool is_dropped) {
  WorldLog& log = index_.worlds[snapshot.world_uid];
  const auto kept = std::upper_bound(
      log.records.begin(), log.records.end(), snapshot.sequence,
      [](std::int64_t sequence, const RecordEntry& entry) { return sequence < entry.sequence; });
  const std::uint32_t chain = log.ChainBefore(static_cast<std::size_t>(kept - log.records.begin()));
  const SnapshotEntry entry = {.row = log.snapshot ? log.snapshot->row : index_.next_snapshot_row,
                               .sequence = snapshot.sequence,
                               .is_dropped = is_dropped,
                               .chain = chain,
                               .crc = SnapshotCrc(snapshot, is_dropped, chain),
                               .blobs = snapshot.blobs};
  StoreMeta meta = meta_;
  if (!log.snapshot) ++meta.snapshot_count;
  meta.snapshot_sum = static_cast<std::uint32_t>(
      meta.snapshot_sum - (log.snapshot ? log.snapshot->crc : 0) + entry.crc);
  absl::Status status = WithBallast([&] {
    return InTransaction(Durability::kObserved, [&]() -> absl::Status {
      absl::StatusOr<Statement> row =
          database_.Prepare(absl::StrCat("INSERT OR REPLACE INTO snapshot(", kSnapshotColumns,
                                         ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"));
      if (!row.ok()) return row.status();
      const std::string blobs = JoinHashes(snapshot.blobs);
      absl::Status put = row->Bind(1, entry.row)
                             .Bind(2, snapshot.sequence)
                             .BindText(3, snapshot.world_uid)
                             .Bind(4, snapshot.revision)
                             .Bind(5, static_cast<std::int64_t>(is_dropped))
                             .Bind(6, entry.chain)
                             .Bind(7, entry.crc)
                             .BindText(8, blobs)
                             .BindBlob(9, snapshot.payload)
                             .Run();
      FailPoint("compaction");
      if (!put.ok()) return put;
      return WriteMeta(database_, meta);
    });
  });
  if (!status.ok()) return status;
  FailPoint("compaction");
  meta_ = meta;
  if (!log.snapshot) ++index_.next_snapshot_row;
  blobs_->AddUses(entry.blobs);
  if (log.snapshot) blobs_->DropUses(log.snapshot->blobs);
  log.snapshot = entry;
  blobs_->DropUses(index_.DropRecords(log, snapshot.sequence));
  PublishCounts();
  return absl::OkStatus();
}

absl::Status SqliteEngine::PutBlob(const std::string& hash, std::string_view bytes,
                                   Durability durability) {
  if (blobs_->Renew(hash, durability)) return absl::OkStatus();
  absl::Status status = CheckRoomFor(static_cast<std::int64_t>(bytes.size()));
  if (!status.ok()) return status;
  return NotedAnywhere(blobs_->Put(hash, bytes, durability));
}

absl::StatusOr<std::string> SqliteEngine::GetBlob(const std::string& hash) const {
  absl::StatusOr<std::string> bytes = blobs_->Get(hash);
  if (!bytes.ok()) return NotedAnywhere(bytes.status());
  return bytes;
}

bool SqliteEngine::HasDurableBlob(const std::string& hash) const {
  return blobs_->Renew(hash, Durability::kDurable);
}

absl::StatusOr<std::unique_ptr<Store::BackupRun>> SqliteEngine::StartBackup() {
  if (absl::Status status = Failure(); !status.ok()) return status;
  if (backup_run_ != nullptr) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "a backup is being made; ask again when it has ended",
                     {.reason = "BACKUP_RUNNING"});
  }
  return SqliteBackupRun::Start(*this);
}

absl::Status SqliteEngine::Close() {
  if (absl::Status status = Failure(); !status.ok()) return status;
  if (is_closed_) return absl::OkStatus();
  if (backup_run_ != nullptr) backup_run_->Abandon();
  // Observed blobs are synced with the rest.
  absl::Status status = blobs_->SyncObserved();
  if (!status.ok()) return Noted(status);
  status = WithBallast([this] {
    return InTransaction(Durability::kDurable, [this] {
      StoreMeta meta = meta_;
      meta.is_closed = true;
      return WriteMeta(database_, meta);
    });
  });
  if (!status.ok()) return status;
  head_.durable = head_.last;
  if (status = head_file_.Write(head_); !status.ok()) return Noted(status);
  if (status = head_file_.Sync(); !status.ok()) return Noted(status);
  const absl::StatusOr<bool> moved = Checkpoint(true);
  if (!moved.ok()) return moved.status();
  is_closed_ = true;
  insert_record_ = {};
  read_records_ = {};
  read_record_ = {};
  delete_record_ = {};
  database_ = {};
  lock_ = {};
  failed_ = StoreFailed(absl::StrCat(directory_, ": the store was closed"));
  return absl::OkStatus();
}

}  // namespace cwm::server
