// What is done to a store's directory while no server has it open: check, tell, restore.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::server {

struct StoreReport {
  std::string store_uid = {};
  std::int64_t version = 0;        // of the tables
  std::int64_t epoch = 0;          // how often it was opened by a server
  std::int64_t last_sequence = 0;  // of the newest record
  std::int64_t world_count = 0;
  std::int64_t record_count = 0;  // not yet folded into snapshots
  std::int64_t record_bytes = 0;
  std::int64_t snapshot_count = 0;
  std::int64_t snapshot_bytes = 0;
  std::int64_t blob_count = 0;  // files
  std::int64_t blob_bytes = 0;
  std::int64_t unused_blob_count = 0;  // a server removes them
  // Blobs that records name and that are not there, or not whole. A power cut may take what was
  // observed; a server then goes on without the objects.
  std::int64_t missing_blob_count = 0;
  std::int64_t database_bytes = 0;
  std::int64_t log_bytes = 0;
  bool was_closed = false;  // false: the server was killed, or the machine went down
  // What is damaged or lost, at most kMaxFaults sentences. Empty if the store is sound.
  std::vector<std::string> faults = {};
  std::int64_t fault_count = 0;
};
inline constexpr std::size_t kMaxFaults = 20;

// Reads everything: pages, records, snapshots, the head and all blobs. Changes nothing. An error
// only if there is no store, a server has it open, or it cannot be read; damage is in the report.
absl::StatusOr<StoreReport> CheckStore(const std::string& path);

// The same without the pages and the content of blobs.
absl::StatusOr<StoreReport> StatStore(const std::string& path);

// Copies a backup, or the directory of a store that no server has open, into a new directory, and
// checks all of the copy. The copy is another store with the same worlds. FailedPrecondition
// STORE_EXISTS if `to` exists, unless it is empty; DataLoss STORE_DAMAGED if the backup is damaged:
// then nothing is left at `to`.
absl::StatusOr<StoreReport> RestoreStore(const std::string& from, const std::string& to);

}  // namespace cwm::server
