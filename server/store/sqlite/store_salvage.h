// Goes on with what is left of a damaged store, if people accept the loss.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/sqlite/sqlite_handles.h"
#include "server/store/sqlite/store_rows.h"

namespace cwm::server {

// Removes what the scan found to be lost, in one transaction, and makes the counts fit. The scan is
// that of the repaired database afterwards. The files as they were are kept in the folder that is
// returned.
absl::StatusOr<std::string> DropLost(Database& database, const std::string& directory,
                                     StoreScan& scan);

// Makes a new database of the rows that can still be read, for one whose pages are damaged, and
// puts it in its place. The files as they were are kept in the folder that is returned. The
// database is closed; the new one is to be opened and scanned.
absl::StatusOr<std::string> Rebuild(Database& database, const std::string& directory);

}  // namespace cwm::server
