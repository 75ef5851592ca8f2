// The rules of store.h that all engines check alike, and their errors.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/store/store.h"

namespace cwm::server {

// ResourceExhausted DISK_FULL, to be tried again in a second.
absl::Status DiskFull(std::string_view what);
// ResourceExhausted OUT_OF_FILES, to be tried again in a second.
absl::Status OutOfFiles(std::string_view what);
// DataLoss STORE_DAMAGED.
absl::Status StoreDamaged(std::string_view what);
// Unavailable STORE_FAILED.
absl::Status StoreFailed(std::string_view what);
// NotFound BLOB_MISSING.
absl::Status BlobMissing(const std::string& hash);

// InvalidArgument STORE_MISUSED if the records are not consecutive, begin behind `last` + 1, name
// no world, or name blobs by what are no hashes. Records that begin earlier were superseded, which is
// no error.
absl::Status CheckRecords(std::span<const StoredRecord> records, std::int64_t last);
// InvalidArgument STORE_MISUSED if the snapshot is older than the world's last one, at `earliest`,
// or newer than the newest record, at `last`.
absl::Status CheckSnapshot(const StoredSnapshot& snapshot, std::int64_t earliest,
                           std::int64_t last);
// InvalidArgument STORE_MISUSED unless it is a SHA-256 in lower-case hex.
absl::Status CheckBlobHash(const std::string& hash);
// StoreDamaged unless the bytes have the hash.
absl::Status CheckBlobBytes(const std::string& hash, std::string_view bytes);

}  // namespace cwm::server
