#include "server/store/sqlite/sqlite_backup.h"

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/failpoint.h"
#include "server/store/sqlite/blob_files.h"
#include "server/store/sqlite/head_file.h"
#include "server/store/sqlite/sqlite_engine.h"
#include "server/store/sqlite/store_files.h"
#include "server/store/sqlite/store_rows.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

constexpr int kPagesPerStep = 256;  // 1 MiB; chosen: a millisecond
constexpr std::size_t kBlobsPerStep = 128;
constexpr int kMaxLinkAttempts = 10;  // chosen: blobs are rarely renamed, lost ones never come

class SqliteBackup final : public Backup {
 public:
  SqliteBackup(std::string folder, std::vector<BackupFile> files, std::int64_t sequence)
      : folder_(std::move(folder)), files_(std::move(files)), sequence_(sequence) {}
  ~SqliteBackup() override {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  SqliteBackup(const SqliteBackup&) = delete;
  SqliteBackup& operator=(const SqliteBackup&) = delete;

  const std::vector<BackupFile>& files() const override { return files_; }
  std::int64_t sequence() const override { return sequence_; }

 private:
  const std::string folder_;
  const std::vector<BackupFile> files_;
  const std::int64_t sequence_;
};

absl::Status WriteHead(const std::string& path, std::int64_t sequence) {
  absl::StatusOr<HeadFile> head = HeadFile::Open(path);
  if (!head.ok()) return head.status();
  return head->Write({.last = sequence, .durable = sequence});
}

absl::Status Abandoned() {
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   "the backup was ended before it was whole", {.reason = "BACKUP_ENDED"});
}

}  // namespace

void FinishBackup::operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }

SqliteBackupRun::SqliteBackupRun(SqliteEngine& engine, std::string folder)
    : engine_(&engine), folder_(std::move(folder)) {
  engine.backup_run_ = this;
}

SqliteBackupRun::~SqliteBackupRun() { Abandon(); }

void SqliteBackupRun::Abandon() {
  if (engine_ == nullptr) return;
  engine_->backup_run_ = nullptr;
  engine_ = nullptr;
  copying_.reset();
  copy_ = {};
  if (folder_.empty()) return;
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

absl::StatusOr<std::unique_ptr<Store::BackupRun>> SqliteBackupRun::Start(SqliteEngine& engine) {
  static std::atomic<int> count = 0;
  std::string folder = absl::StrCat(engine.directory_, "/", kBackupPrefix, ++count);
  if (mkdir(folder.c_str(), 0700) != 0) return FileError(folder, "cannot be created", errno);
  std::unique_ptr<SqliteBackupRun> run(new SqliteBackupRun(engine, std::move(folder)));
  if (absl::Status status = run->Prepare(); !status.ok()) return status;
  return run;
}

absl::Status SqliteBackupRun::Prepare() {
  if (absl::Status status = MakeBlobFolder(folder_); !status.ok()) return status;
  absl::StatusOr<Database> copy = Database::Open(absl::StrCat(folder_, "/", kDatabaseFile), true);
  if (!copy.ok()) return copy.status();
  copy_ = *std::move(copy);
  // Who reads the backup syncs what it writes; a copy that was cut off is removed.
  if (absl::Status status = copy_.Execute("PRAGMA synchronous = OFF"); !status.ok()) return status;
  copying_.reset(sqlite3_backup_init(copy_.get(), "main", engine_->database_.get(), "main"));
  if (copying_ == nullptr) return copy_.StatusOf(sqlite3_extended_errcode(copy_.get()));
  return absl::OkStatus();
}

absl::StatusOr<bool> SqliteBackupRun::LinkBlobs(std::size_t count) {
  std::vector<std::string> added;
  bool is_done = true;
  for (const BlobName& blob : engine_->blobs_->Used()) {
    if (std::binary_search(linked_.begin(), linked_.end(), blob.path)) continue;
    const std::string from = absl::StrCat(engine_->directory_, "/", blob.path);
    // A blob that has just become durable has another name, which the next step finds.
    if (added.size() == count || access(from.c_str(), F_OK) != 0) {
      is_done = false;
      continue;
    }
    const std::string to = absl::StrCat(folder_, "/", blob.path);
    if (absl::Status status = MakeFolderOf(to); !status.ok()) return status;
    if (absl::Status status = LinkOrCopy(from, to); !status.ok()) return status;
    added.push_back(blob.path);
  }
  linked_.insert(linked_.end(), added.begin(), added.end());
  std::sort(linked_.begin(), linked_.end());
  return is_done;
}

absl::StatusOr<std::unique_ptr<Backup>> SqliteBackupRun::Step() {
  if (engine_ == nullptr) return Abandoned();
  FailPoint("backup");
  const absl::StatusOr<bool> linked = LinkBlobs(kBlobsPerStep);
  if (!linked.ok()) return linked.status();
  if (!*linked) return nullptr;
  // What the store writes between two steps SQLite writes into the copy as well, because it goes
  // through the same connection.
  const int code = sqlite3_backup_step(copying_.get(), kPagesPerStep);
  if (code == SQLITE_OK) return nullptr;
  if (code != SQLITE_DONE) {
    copying_.reset();
    return copy_.StatusOf(code);
  }
  return Finish();
}

// The copy is that of the last step, so it is finished within it: nothing is appended meanwhile.
absl::StatusOr<std::unique_ptr<Backup>> SqliteBackupRun::Finish() {
  copying_.reset();
  absl::StatusOr<bool> linked = false;
  for (int i = 0; i < kMaxLinkAttempts && linked.ok() && !*linked; ++i) {
    linked = LinkBlobs(std::numeric_limits<std::size_t>::max());
  }
  if (!linked.ok()) return linked.status();
  for (const char* sql : {"PRAGMA locking_mode = EXCLUSIVE", "PRAGMA journal_mode = DELETE"}) {
    if (absl::Status status = copy_.Execute(sql); !status.ok()) return status;
  }
  StoreMeta meta = engine_->meta_;
  meta.is_closed = true;
  meta.lacks_durable = true;  // what the store appends after it
  absl::Status status = WriteMeta(copy_, meta);
  if (!status.ok()) return status;
  copy_ = {};
  const std::int64_t sequence = engine_->last_sequence();
  status = WriteHead(absl::StrCat(folder_, "/", kHeadFile), sequence);
  if (!status.ok()) return status;
  std::vector<BackupFile> files;
  for (const char* name : {kDatabaseFile, kHeadFile}) {
    files.push_back({name, absl::StrCat(folder_, "/", name)});
  }
  for (const std::string& path : linked_) {
    files.push_back({path, absl::StrCat(folder_, "/", path)});
  }
  FailPoint("backup");
  auto backup = std::make_unique<SqliteBackup>(std::move(folder_), std::move(files), sequence);
  folder_.clear();
  Abandon();
  return backup;
}

}  // namespace cwm::server
