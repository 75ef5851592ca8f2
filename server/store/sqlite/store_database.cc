#include "server/store/sqlite/store_database.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <random>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/failpoint.h"
#include "server/store/sqlite/blob_files.h"
#include "server/store/sqlite/head_file.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

absl::Status Rename(const std::string& from, const std::string& to, const std::string& directory) {
  if (rename(from.c_str(), to.c_str()) != 0) return FileError(to, "cannot be created", errno);
  return SyncFile(directory);
}

// Copies the database as it is, with its log, before it is migrated.
absl::Status KeepCopy(Database& database, const std::string& directory, std::int64_t version) {
  const std::string copy = absl::StrCat(directory, "/", kDatabaseFile, ".v", version, ".bak");
  const std::string unfinished = copy + ".new";
  unlink(unfinished.c_str());
  absl::StatusOr<Statement> vacuum = database.Prepare("VACUUM INTO ?");
  if (!vacuum.ok()) return vacuum.status();
  if (absl::Status status = vacuum->BindText(1, unfinished).Run(); !status.ok()) return status;
  if (absl::Status status = SyncFile(unfinished); !status.ok()) return status;
  return Rename(unfinished, copy, directory);
}

// The faults that SQLite finds in the structure of the pages.
absl::Status CheckPages(Database& database) {
  const absl::StatusOr<std::string> found = database.Text("PRAGMA quick_check(1)");
  if (!found.ok()) return found.status();
  if (*found == "ok") return absl::OkStatus();
  return StoreDamaged(absl::StrCat("the pages are damaged: ", *found));
}

}  // namespace

std::string NewStoreUid() {
  std::random_device random;
  std::string uid;
  for (int i = 0; i < 4; ++i) absl::StrAppend(&uid, absl::Hex(random(), absl::kZeroPad8));
  return uid;
}

absl::Status WriteTables(const std::string& path) {
  absl::StatusOr<Database> database = Database::Open(path, true);
  if (!database.ok()) return database.status();
  for (const std::string& sql :
       {std::string("PRAGMA page_size = 4096"), std::string("PRAGMA synchronous = FULL"),
        std::string("BEGIN"), absl::StrCat("PRAGMA application_id = ", kApplicationId),
        absl::StrCat("PRAGMA user_version = ", kSchemaVersion), std::string(kSchema)}) {
    if (absl::Status status = database->Execute(sql); !status.ok()) return status;
  }
  const StoreMeta meta = {.store_uid = NewStoreUid()};
  if (absl::Status status = WriteMeta(*database, meta); !status.ok()) return status;
  return database->Execute("COMMIT");
}

absl::Status CreateStore(const std::string& directory) {
  if (absl::Status status = MakeBlobFolder(directory); !status.ok()) return status;
  const absl::StatusOr<HeadFile> head = HeadFile::Open(absl::StrCat(directory, "/", kHeadFile));
  if (!head.ok()) return head.status();
  const std::string unfinished = absl::StrCat(directory, "/", kNewDatabaseFile);
  if (absl::Status status = WriteTables(unfinished); !status.ok()) {
    unlink(unfinished.c_str());
    return status;
  }
  absl::Status status = Rename(unfinished, absl::StrCat(directory, "/", kDatabaseFile), directory);
  if (!status.ok()) return status;
  return SyncParent(directory);
}

absl::StatusOr<Database> OpenStoreDatabase(const std::string& directory, DatabaseUse use,
                                           const std::string& vfs) {
  const std::string path = absl::StrCat(directory, "/", kDatabaseFile);
  if (absl::Status status = CheckDatabaseHeader(path); !status.ok()) return status;
  absl::StatusOr<Database> database = Database::Open(path, false, vfs);
  if (!database.ok()) return database;
  // Exclusive from the first access on: no shared memory, and no other connection ever.
  for (const char* sql : {"PRAGMA locking_mode = EXCLUSIVE", "PRAGMA trusted_schema = OFF",
                          "PRAGMA cell_size_check = ON", "PRAGMA temp_store = MEMORY",
                          "PRAGMA secure_delete = OFF"}) {
    if (absl::Status status = database->Execute(sql); !status.ok()) return status;
  }
  if (use == DatabaseUse::kRead) return database;
  const absl::StatusOr<std::string> mode = database->Text("PRAGMA journal_mode = WAL");
  if (!mode.ok()) return mode.status();
  if (*mode != "wal") {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat(path, ": has the journal mode ", *mode,
                                  ", must take wal; use another file system"),
                     {.reason = "STORE_NOT_WRITABLE"});
  }
  for (const char* sql : {"PRAGMA wal_autocheckpoint = 0", "PRAGMA synchronous = FULL"}) {
    if (absl::Status status = database->Execute(sql); !status.ok()) return status;
  }
  return database;
}

absl::Status Migrate(Database& database, const std::string& directory,
                     const Migrations& migrations) {
  const absl::StatusOr<std::int64_t> version = database.Int("PRAGMA user_version");
  if (!version.ok()) return version.status();
  const std::int64_t newest = kSchemaVersion + static_cast<std::int64_t>(migrations.size());
  if (*version == newest) return absl::OkStatus();
  if (*version > newest) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat(directory, ": is of version ", *version,
                                  ", this program knows versions up to ", newest,
                                  "; use the newer program, or restore a backup of the older one"),
                     {.reason = "STORE_NEWER"});
  }
  if (*version < kSchemaVersion) {
    return StoreDamaged(absl::StrCat(directory, ": is of version ", *version, ", must be ",
                                     kSchemaVersion, " to ", newest));
  }
  FailPoint("migration");
  if (absl::Status status = KeepCopy(database, directory, *version); !status.ok()) return status;
  absl::StatusOr<Transaction> transaction = Transaction::Begin(database);
  if (!transaction.ok()) return transaction.status();
  for (std::int64_t from = *version; from < newest; ++from) {
    const std::string& step = migrations[static_cast<std::size_t>(from - kSchemaVersion)];
    if (absl::Status status = database.Execute(step); !status.ok()) return status;
    FailPoint("migration");
  }
  const std::string set_version = absl::StrCat("PRAGMA user_version = ", newest);
  if (absl::Status status = database.Execute(set_version); !status.ok()) return status;
  if (absl::Status status = transaction->Commit(); !status.ok()) return status;
  FailPoint("migration");
  return absl::OkStatus();
}

absl::StatusOr<StoreScan> ReadWholeStore(Database& database, const std::string& directory,
                                         bool check_pages) {
  if (check_pages) {
    if (absl::Status status = CheckPages(database); !status.ok()) return status;
  }
  absl::StatusOr<StoreScan> scan = ScanStore(database);
  if (!scan.ok()) return scan;
  const std::int64_t last = scan->index.last_sequence;
  const absl::StatusOr<Head> head = ReadHead(absl::StrCat(directory, "/", kHeadFile));
  if (!head.ok()) {
    scan->faults.emplace_back(head.status().message());
    return scan;
  }
  const bool cache_survived = scan->meta.is_closed || scan->meta.cache == CurrentCache(directory);
  const std::int64_t acknowledged = cache_survived ? head->last : head->durable;
  if (last < acknowledged) {
    const auto missing = static_cast<std::size_t>(acknowledged - last);
    scan->faults.push_back(absl::StrCat(Counted(missing, "acknowledged record"), " after record ",
                                        last, missing == 1 ? " is" : " are", " missing"));
  }
  return scan;
}

}  // namespace cwm::server
