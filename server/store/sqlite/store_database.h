// Makes, opens, migrates and repairs the database of a store.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/sqlite_handles.h"
#include "server/store/sqlite/store_rows.h"

namespace cwm::server {

// Makes an empty store in the directory, durably: a process that is killed meanwhile leaves nothing
// that counts.
absl::Status CreateStore(const std::string& directory);

// Opens store.db alone, with its log. Nothing is written.
absl::StatusOr<Database> OpenStoreDatabase(const std::string& directory,
                                           const std::string& vfs = {});

// The steps from one version of the tables to the next: SQL that is run in one transaction. The
// first leads from version 1 to 2.
using Migrations = std::vector<std::string>;

// Brings the tables to the newest version, kSchemaVersion + migrations.size(), and keeps a copy of
// the old database as store.db.v1.bak. FailedPrecondition STORE_NEWER for a later version.
absl::Status Migrate(Database& database, const std::string& directory,
                     const Migrations& migrations);

// Reads the whole database and compares it with the head: what was acknowledged must be there.
// `cache_survived`: what was written but not synced must be there as well. With `check_pages`,
// SQLite's quick_check precedes.
absl::StatusOr<StoreScan> ReadWholeStore(Database& database, const std::string& directory,
                                         bool check_pages);

// Removes what the scan found to be lost, in one transaction, and makes the counts fit. The scan is
// that of the repaired database afterwards. The files as they were are kept in the folder that is
// returned.
absl::StatusOr<std::string> DropLost(Database& database, const std::string& directory,
                                     StoreScan& scan);

}  // namespace cwm::server
