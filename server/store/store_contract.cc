#include "server/store/store_contract.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "proto/transfer/sha256.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

constexpr std::size_t kHashLength = 64;  // derived: 256 bits, four for each digit
// chosen: long enough for a file to be removed or a checkpoint to end, short for a person.
constexpr double kRetryAfterSeconds = 1.0;

absl::Status Misused(std::string message) {
  return MakeError(absl::StatusCode::kInvalidArgument, std::move(message),
                   {.reason = "STORE_MISUSED"});
}

absl::Status CheckBlobHashes(const std::vector<std::string>& hashes) {
  for (const std::string& hash : hashes) {
    if (absl::Status status = CheckBlobHash(hash); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DiskFull(std::string_view what) {
  return Overloaded(std::string(what), "DISK_FULL", kRetryAfterSeconds);
}

absl::Status OutOfFiles(std::string_view what) {
  return Overloaded(std::string(what), "OUT_OF_FILES", kRetryAfterSeconds);
}

absl::Status StoreDamaged(std::string_view what) {
  return MakeError(absl::StatusCode::kDataLoss, std::string(what), {.reason = "STORE_DAMAGED"});
}

absl::Status StoreFailed(std::string_view what) {
  return MakeError(absl::StatusCode::kUnavailable, std::string(what), {.reason = "STORE_FAILED"});
}

absl::Status BlobMissing(const std::string& hash) {
  return MakeError(absl::StatusCode::kNotFound, absl::StrCat("the store has no blob ", hash),
                   {.reason = "BLOB_MISSING"});
}

absl::Status CheckRecords(std::span<const StoredRecord> records, std::int64_t last) {
  if (records.empty()) return absl::OkStatus();
  std::int64_t expected = records.front().sequence;
  if (expected < 1 || expected > last + 1) {
    return Misused(absl::StrCat("records[0].sequence: is ", expected, ", must be ", last + 1));
  }
  for (std::size_t i = 0; i < records.size(); ++i, ++expected) {
    if (records[i].sequence != expected) {
      return Misused(absl::StrCat("records[", i, "].sequence: is ", records[i].sequence,
                                  ", must be ", expected));
    }
    if (records[i].world_uid.empty()) {
      return Misused(absl::StrCat("records[", i, "].world_uid: is empty, must name a world"));
    }
    if (absl::Status status = CheckBlobHashes(records[i].blobs); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status CheckSnapshot(const StoredSnapshot& snapshot, std::int64_t earliest,
                           std::int64_t last) {
  if (snapshot.world_uid.empty()) {
    return Misused("snapshot.world_uid: is empty, must name a world");
  }
  if (snapshot.sequence < earliest || snapshot.sequence > last) {
    return Misused(absl::StrCat("snapshot.sequence: is ", snapshot.sequence, ", must be ", earliest,
                                " to ", last));
  }
  return CheckBlobHashes(snapshot.blobs);
}

absl::Status CheckBlobHash(const std::string& hash) {
  const bool is_hash =
      hash.size() == kHashLength && std::all_of(hash.begin(), hash.end(), [](char digit) {
        return (digit >= '0' && digit <= '9') || (digit >= 'a' && digit <= 'f');
      });
  if (is_hash) return absl::OkStatus();
  return Misused(absl::StrCat("blob: is named '", hash, "', must be a SHA-256 in lower-case hex"));
}

absl::Status CheckBlobBytes(const std::string& hash, std::string_view bytes) {
  const std::string found = Sha256Hex(bytes);
  if (found == hash) return absl::OkStatus();
  return StoreDamaged(
      absl::StrCat("blob ", hash, ": its ", bytes.size(), " bytes have the SHA-256 ", found));
}

}  // namespace cwm::server
