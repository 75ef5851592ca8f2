#include "server/store/sqlite/store_directory.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/store/sqlite/blob_files.h"
#include "server/store/sqlite/head_file.h"
#include "server/store/sqlite/store_database.h"
#include "server/store/sqlite/store_files.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

class ReportWriter {
 public:
  explicit ReportWriter(std::string path) : path_(std::move(path)) {}

  void AddFault(std::string fault) {
    if (report.faults.size() < kMaxFaults) report.faults.push_back(std::move(fault));
    ++report.fault_count;
  }
  // A damaged store is reported; any other error ends the check.
  absl::Status AddScan(bool check_pages);
  absl::Status AddBlobs(bool read_all);

  StoreReport report;

 private:
  std::string InStore(const std::string& name) const { return absl::StrCat(path_, "/", name); }

  const std::string path_;
  std::set<std::string> named_blobs_;
};

absl::Status ReportWriter::AddScan(bool check_pages) {
  report.database_bytes = FileSize(InStore(kDatabaseFile));
  report.log_bytes = FileSize(InStore(kLogFile));
  const auto faulty = [this](const absl::Status& status) {
    if (status.code() != absl::StatusCode::kDataLoss) return status;
    AddFault(std::string(status.message()));
    return absl::OkStatus();
  };
  absl::StatusOr<Database> database = OpenStoreDatabase(path_, DatabaseUse::kRead);
  if (!database.ok()) return faulty(database.status());
  const absl::StatusOr<std::int64_t> version = database->Int("PRAGMA user_version");
  if (!version.ok()) return faulty(version.status());
  report.version = *version;
  if (*version != kSchemaVersion) {
    return MakeError(
        absl::StatusCode::kFailedPrecondition,
        absl::StrCat(path_, ": is of version ", *version, ", this program reads version ",
                     kSchemaVersion, "; a server of the same version as the store reads it"),
        {.reason = *version > kSchemaVersion ? "STORE_NEWER" : "STORE_OLDER"});
  }
  const absl::StatusOr<StoreScan> scan = ReadWholeStore(*database, path_, check_pages);
  if (!scan.ok()) return faulty(scan.status());
  report.store_uid = scan->meta.store_uid;
  report.epoch = scan->meta.epoch;
  report.was_closed = scan->meta.is_closed;
  report.last_sequence = scan->index.last_sequence;
  report.record_count = scan->index.record_count;
  report.record_bytes = scan->index.record_bytes;
  report.snapshot_bytes = scan->snapshot_bytes;
  for (const std::string& fault : scan->faults) AddFault(fault);
  for (const auto& [sequence, blobs] : scan->index.record_blobs) {
    named_blobs_.insert(blobs.begin(), blobs.end());
  }
  for (const auto& [world, log] : scan->index.worlds) {
    const bool has_snapshot = log.snapshot && !log.snapshot->is_dropped;
    if (has_snapshot || !log.records.empty()) ++report.world_count;
    if (!has_snapshot) continue;
    ++report.snapshot_count;
    named_blobs_.insert(log.snapshot->blobs.begin(), log.snapshot->blobs.end());
  }
  return absl::OkStatus();
}

absl::Status ReportWriter::AddBlobs(bool read_all) {
  const absl::StatusOr<std::vector<BlobName>> blobs = ListBlobs(path_, false);
  if (!blobs.ok()) return blobs.status();
  std::set<std::string> missing = named_blobs_;
  for (const BlobName& blob : *blobs) {
    ++report.blob_count;
    report.blob_bytes += blob.size;
    const bool is_named = named_blobs_.contains(blob.hash);
    if (!is_named) ++report.unused_blob_count;
    if (read_all) {
      const absl::StatusOr<std::string> bytes = ReadFile(InStore(blob.path));
      if (!bytes.ok()) return bytes.status();
      const absl::Status status = CheckBlobBytes(blob.hash, *bytes);
      const bool is_durable = blob.path == BlobPath(blob.hash, true);
      if (!status.ok() && is_durable && is_named) AddFault(std::string(status.message()));
      if (!status.ok()) continue;
    }
    missing.erase(blob.hash);
  }
  report.missing_blob_count = static_cast<std::int64_t>(missing.size());
  return absl::OkStatus();
}

absl::StatusOr<std::string> StoreAt(const std::string& given) {
  const std::string path = AbsolutePath(given);
  const absl::StatusOr<DirectoryContent> content = InspectDirectory(path);
  if (!content.ok()) return content.status();
  if (*content == DirectoryContent::kNothing) {
    return MakeError(absl::StatusCode::kNotFound,
                     absl::StrCat(path, ": there is no store; name the directory of one"),
                     {.reason = "STORE_MISSING"});
  }
  return path;
}

// Locks the directory of a store. A backup that no server has opened has no lock, and gets none.
absl::StatusOr<FileDescriptor> LockIfOpened(const std::string& path) {
  if (access(absl::StrCat(path, "/", kLockFile).c_str(), F_OK) != 0) return FileDescriptor();
  return LockDirectory(path);
}

absl::StatusOr<StoreReport> Report(const std::string& given, bool read_all) {
  const absl::StatusOr<std::string> path = StoreAt(given);
  if (!path.ok()) return path.status();
  const absl::StatusOr<FileDescriptor> lock = LockIfOpened(*path);
  if (!lock.ok()) return lock.status();
  ReportWriter writer(*path);
  if (absl::Status status = writer.AddScan(read_all); !status.ok()) return status;
  if (absl::Status status = writer.AddBlobs(read_all); !status.ok()) return status;
  return std::move(writer.report);
}

// Copies a file and syncs the copy.
absl::Status CopyFile(const std::string& from, const std::string& to) {
  std::error_code error;
  fs::copy_file(from, to, error);
  if (error) return FileError(from, absl::StrCat("cannot be copied to ", to), error.value());
  return SyncFile(to);
}

absl::Status CopyStore(const std::string& from, const std::string& to) {
  if (absl::Status status = MakeBlobFolder(to); !status.ok()) return status;
  for (const char* name : {kDatabaseFile, kLogFile, kHeadFile}) {
    const std::string source = absl::StrCat(from, "/", name);
    if (access(source.c_str(), F_OK) != 0) continue;
    if (absl::Status status = CopyFile(source, absl::StrCat(to, "/", name)); !status.ok()) {
      return status;
    }
  }
  const absl::StatusOr<std::vector<BlobName>> blobs = ListBlobs(from, false);
  if (!blobs.ok()) return blobs.status();
  std::set<std::string> folders = {to, absl::StrCat(to, "/", kBlobFolder)};
  for (const BlobName& blob : *blobs) {
    const std::string copy = absl::StrCat(to, "/", blob.path);
    if (absl::Status status = MakeFolderOf(copy); !status.ok()) return status;
    absl::Status status = CopyFile(absl::StrCat(from, "/", blob.path), copy);
    if (!status.ok()) return status;
    folders.insert(fs::path(copy).parent_path().string());
  }
  for (const std::string& folder : folders) {
    if (absl::Status status = SyncFile(folder); !status.ok()) return status;
  }
  return absl::OkStatus();
}

// Makes the copy a store of its own, which lacks what the other one stored since.
absl::Status NameAnew(const std::string& path) {
  absl::StatusOr<Database> database = OpenStoreDatabase(path, DatabaseUse::kWrite);
  if (!database.ok()) return database.status();
  absl::StatusOr<StoreMeta> meta = ReadMeta(*database);
  if (!meta.ok()) return meta.status();
  meta->store_uid = NewStoreUid();
  meta->lacks_durable = true;
  if (absl::Status status = WriteMeta(*database, *meta); !status.ok()) return status;
  return database->Execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

absl::StatusOr<StoreReport> CopyAndCheck(const std::string& from, const std::string& to) {
  if (absl::Status status = CopyStore(from, to); !status.ok()) return status;
  absl::StatusOr<StoreReport> report = CheckStore(to);
  if (!report.ok()) return report;
  if (report->fault_count > 0) {
    return StoreDamaged(absl::StrCat(from, ": ", report->faults.front(), " (faults found: ",
                                     report->fault_count, "); restore another backup"));
  }
  if (absl::Status status = NameAnew(to); !status.ok()) return status;
  if (absl::Status status = SyncParent(to); !status.ok()) return status;
  return report;
}

}  // namespace

absl::StatusOr<StoreReport> CheckStore(const std::string& path) { return Report(path, true); }

absl::StatusOr<StoreReport> StatStore(const std::string& path) { return Report(path, false); }

absl::StatusOr<StoreReport> RestoreStore(const std::string& from, const std::string& to) {
  const absl::StatusOr<std::string> source = StoreAt(from);
  if (!source.ok()) return source.status();
  const absl::StatusOr<FileDescriptor> lock = LockIfOpened(*source);
  if (!lock.ok()) return lock.status();
  const fs::path target = AbsolutePath(to);
  std::error_code error;
  const bool existed = fs::exists(target, error);
  if (existed && !(fs::is_directory(target, error) && fs::is_empty(target, error))) {
    return MakeError(
        absl::StatusCode::kFailedPrecondition,
        absl::StrCat(target.string(), ": exists already; restore into a new directory"),
        {.reason = "STORE_EXISTS"});
  }
  if (!existed && mkdir(target.c_str(), 0700) != 0) {
    return FileError(target.string(), "cannot be created", errno);
  }
  absl::StatusOr<StoreReport> report = CopyAndCheck(*source, target.string());
  if (!report.ok()) {
    for (const fs::directory_entry& entry : fs::directory_iterator(target, error)) {
      fs::remove_all(entry.path(), error);
    }
    if (!existed) fs::remove(target, error);
  }
  return report;
}

}  // namespace cwm::server
