// The files of a store's directory, and what is asked of the system about them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/core/file_descriptor.h"

namespace cwm::server {

inline constexpr char kDatabaseFile[] = "store.db";
inline constexpr char kLogFile[] = "store.db-wal";
inline constexpr char kNewDatabaseFile[] = "store.db.new";  // a store that is being created
inline constexpr char kHeadFile[] = "head";
inline constexpr char kLockFile[] = "lock";
inline constexpr char kBallastFile[] = "ballast";
inline constexpr char kBlobFolder[] = "blobs";
inline constexpr char kBackupPrefix[] = "backup-";  // folders of backups that are being sent

// The errors of store.h for a failed call of the system on a file, by errno.
absl::Status FileError(const std::string& path, std::string_view what, int error);
// The same for a file that could not be opened, which changed nothing: without descriptors or
// memory it is ResourceExhausted OUT_OF_FILES, and the call may be repeated.
absl::Status OpenError(const std::string& path, std::string_view what, int error);

absl::StatusOr<std::string> ReadFile(const std::string& path);
// Writes a file that does not exist yet, and syncs it if asked to. A file that cannot be written
// whole is removed.
absl::Status WriteNewFile(const std::string& path, std::string_view bytes, bool sync);
// The path from the root, without a slash at its end.
std::string AbsolutePath(const std::string& path);
// Syncs the name of a directory that was made. The directory above it may be closed to this user.
absl::Status SyncParent(const std::string& directory);
// Syncs a file, with its length, or a directory, with the names in it.
absl::Status SyncFile(const std::string& path);
// A hard link, or a copy where the file system has none.
absl::Status LinkOrCopy(const std::string& from, const std::string& to);
std::int64_t FileSize(const std::string& path);   // 0 if there is none
std::int64_t FreeBytes(const std::string& path);  // for this user, on the file system of the path

// Holds the directory's lock until it is destroyed. FailedPrecondition STORE_LOCKED with the id of
// the process that holds it.
absl::StatusOr<FileDescriptor> LockDirectory(const std::string& directory);

// What keeps data that was written but not synced: it is gone when either changes. The mount is
// told from its successors by Linux from 6.8 on; before, only if it got another number.
struct CacheIdentity {
  std::string boot = {};
  std::string mount = {};
  friend bool operator==(const CacheIdentity&, const CacheIdentity&) = default;
};
CacheIdentity CurrentCache(const std::string& directory);

// FailedPrecondition STORE_ON_NETWORK if the directory is on a file system that is known to break
// locks or syncs. Sets `warning` if what it keeps ends with the machine.
absl::Status CheckFileSystem(const std::string& directory, bool allow_network_mount,
                             std::string& warning);

enum class DirectoryContent {
  kNothing,  // no such directory, or an empty one, or one whose creation was interrupted
  kStore,
};
// FailedPrecondition STORE_FOREIGN if other things are there; DataLoss STORE_DAMAGED if a store's
// database is missing.
absl::StatusOr<DirectoryContent> InspectDirectory(const std::string& directory);
// Ok if the file begins as a database of a store does, by SQLite's header: STORE_FOREIGN else.
absl::Status CheckDatabaseHeader(const std::string& path);
inline constexpr std::uint32_t kApplicationId = 0x63776d31;  // "cwm1"

// Removes what an earlier process left half made: backups, a new database.
void RemoveLeftovers(const std::string& directory);

}  // namespace cwm::server
