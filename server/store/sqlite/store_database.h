// Makes, opens, migrates and reads the database of a store.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/sqlite_handles.h"
#include "server/store/sqlite/store_rows.h"

namespace cwm::server {

// A random name by which a store is told from others.
std::string NewStoreUid();

// Makes a database with empty tables.
absl::Status WriteTables(const std::string& path);

// Makes an empty store in the directory, durably: a process that is killed meanwhile leaves nothing
// that counts.
absl::Status CreateStore(const std::string& directory);

enum class DatabaseUse {
  kRead,   // changes no file
  kWrite,  // with a log (WAL) from now on
};
// Opens store.db alone, with its log if it has one.
absl::StatusOr<Database> OpenStoreDatabase(const std::string& directory, DatabaseUse use,
                                           const std::string& vfs = {});

// The steps from one version of the tables to the next: SQL that is run in one transaction. The
// first leads from version 1 to 2.
using Migrations = std::vector<std::string>;

// Brings the tables to the newest version, kSchemaVersion + migrations.size(), and keeps a copy of
// the old database as store.db.v1.bak. FailedPrecondition STORE_NEWER for a later version.
absl::Status Migrate(Database& database, const std::string& directory,
                     const Migrations& migrations);

// Reads the whole database and compares it with the head: what was acknowledged must be there, as
// far as a power cut cannot have taken it. With `check_pages`, SQLite's quick_check precedes.
absl::StatusOr<StoreScan> ReadWholeStore(Database& database, const std::string& directory,
                                         bool check_pages);

}  // namespace cwm::server
