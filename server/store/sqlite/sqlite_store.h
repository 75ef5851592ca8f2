// The store on SQLite: a directory with store.db, its log store.db-wal, the files head, lock and
// ballast, and the blobs as files. One connection, used by the journal's thread, holds the database
// exclusively.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/store/store.h"

namespace cwm::server {

struct SqliteOptions {
  std::string path = {};  // the store's directory: made if it does not exist, in one that does
  // Goes on without records that are missing or damaged. The files as they were are kept.
  bool accept_loss = false;
  bool allow_network_mount = false;
  // Called with sentences that people should read; nothing is wrong with the store.
  std::function<void(const std::string&)> warn = {};

  // chosen: a checkpoint of one log file and some seconds of records fit.
  std::int64_t ballast_bytes = std::int64_t{16} << 20;
  // Appending is refused when the disk has less than this besides the ballast. chosen: what the log
  // may grow by before the room is looked at again.
  std::int64_t low_water_bytes = std::int64_t{8} << 20;
  // Blobs without uses are kept this long after they were put: the record follows.
  std::chrono::seconds blob_grace = std::chrono::minutes(10);
  std::vector<std::string> migrations = {};  // see store_database.h
  std::string vfs = {};                      // of SQLite; empty: the system's
};

// FailedPrecondition STORE_FOREIGN, STORE_NEWER, STORE_LOCKED, STORE_ON_NETWORK or
// STORE_NOT_WRITABLE, DataLoss STORE_DAMAGED, ResourceExhausted DISK_FULL, Unavailable
// STORE_FAILED; each message says what to do.
absl::StatusOr<std::unique_ptr<Store>> OpenSqliteStore(const SqliteOptions& options);

}  // namespace cwm::server
