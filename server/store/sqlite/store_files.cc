#include "server/store/sqlite/store_files.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/store/sqlite/head_file.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kSmb2Magic = 0xFE534D42;  // cited: fs/smb/client/smb2pdu.h of Linux
constexpr std::uint32_t kCifsMagic = 0xFF534D42;
constexpr unsigned kStatxUniqueMountId = 0x4000;  // STATX_MNT_ID_UNIQUE, Linux 6.8

absl::Status Refused(std::string message, std::string reason) {
  return MakeError(absl::StatusCode::kFailedPrecondition, std::move(message),
                   {.reason = std::move(reason)});
}

// Names that a store's directory has before its database is there, and those of a file system.
bool MayBeBesideNoDatabase(const std::string& name) {
  return name == kHeadFile || name == kLockFile || name == kBallastFile || name == kBlobFolder ||
         name == kNewDatabaseFile || name == absl::StrCat(kNewDatabaseFile, "-journal") ||
         name == "lost+found";
}

std::string ProcessIn(int fd) {
  std::array<char, 16> text{};  // longer than any process id
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "unknown";
}

std::uint32_t BigEndian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

}  // namespace

absl::Status FileError(const std::string& path, std::string_view what, int error) {
  const std::string message =
      absl::StrCat(path, ": ", std::string(what), ": ", std::strerror(error));
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return DiskFull(message);
    case EACCES:
    case EPERM:
    case EROFS:
    case ENOENT:
    case ENOTDIR:
      return Refused(
          absl::StrCat(message, "; the directory must exist and be writable for user ", geteuid()),
          "STORE_NOT_WRITABLE");
    default:
      return StoreFailed(message);
  }
}

absl::Status OpenError(const std::string& path, std::string_view what, int error) {
  if (error != EMFILE && error != ENFILE && error != ENOMEM) return FileError(path, what, error);
  return OutOfFiles(absl::StrCat(path, ": ", std::string(what), ": ", std::strerror(error)));
}

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return OpenError(path, "cannot be opened", errno);
  struct stat info {};
  if (fstat(file.number(), &info) != 0) return FileError(path, "cannot be read", errno);
  std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = read(file.number(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return FileError(path, "cannot be read", errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  bytes.resize(done);
  return bytes;
}

absl::Status WriteNewFile(const std::string& path, std::string_view bytes, bool sync) {
  const FileDescriptor file(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!file.is_open()) return OpenError(path, "cannot be created", errno);
  const auto fail = [&path](std::string_view what, int error) {
    unlink(path.c_str());
    return FileError(path, what, error);
  };
  while (!bytes.empty()) {
    const ssize_t n = write(file.number(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail("cannot be written", errno);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  if (sync && fdatasync(file.number()) != 0) return fail("cannot be synced", errno);
  return absl::OkStatus();
}

absl::Status SyncFile(const std::string& path) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return OpenError(path, "cannot be opened", errno);
  if (fsync(file.number()) != 0) return FileError(path, "cannot be synced", errno);
  return absl::OkStatus();
}

std::string AbsolutePath(const std::string& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error).lexically_normal();
  if (!absolute.has_filename()) absolute = absolute.parent_path();
  return error ? path : absolute.string();
}

absl::Status SyncParent(const std::string& directory) {
  absl::Status status = SyncFile(fs::path(directory).parent_path().string());
  if (status.code() == absl::StatusCode::kFailedPrecondition) return absl::OkStatus();
  return status;
}

absl::Status LinkOrCopy(const std::string& from, const std::string& to) {
  if (link(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  std::error_code error;
  fs::copy_file(from, to, error);
  if (error) return FileError(from, "cannot be copied", error.value());
  return absl::OkStatus();
}

std::int64_t FileSize(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? info.st_size : 0;
}

std::int64_t FreeBytes(const std::string& path) {
  struct statvfs info {};
  if (statvfs(path.c_str(), &info) != 0) return 0;
  return static_cast<std::int64_t>(info.f_bavail) * static_cast<std::int64_t>(info.f_frsize);
}

absl::StatusOr<FileDescriptor> LockDirectory(const std::string& directory) {
  const std::string path = absl::StrCat(directory, "/", kLockFile);
  FileDescriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!file.is_open()) return FileError(path, "cannot be opened", errno);
  if (flock(file.number(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return FileError(path, "cannot be locked", errno);
    return Refused(absl::StrCat(directory, ": process ", ProcessIn(file.number()),
                                " has the store open; end it first, or use another directory"),
                   "STORE_LOCKED");
  }
  // The process id is for people to read; without it the lock holds all the same.
  const std::string pid = std::to_string(getpid());
  if (ftruncate(file.number(), 0) == 0) {
    [[maybe_unused]] const ssize_t written = pwrite(file.number(), pid.data(), pid.size(), 0);
  }
  return file;
}

CacheIdentity CurrentCache(const std::string& directory) {
  CacheIdentity identity;
  std::array<char, 64> boot{};
  const FileDescriptor file(open("/proc/sys/kernel/random/boot_id", O_RDONLY | O_CLOEXEC));
  if (const ssize_t size = read(file.number(), boot.data(), boot.size()); size > 0) {
    identity.boot.assign(boot.data(), static_cast<std::size_t>(size));
    while (!identity.boot.empty() && identity.boot.back() == '\n') identity.boot.pop_back();
  }
  struct statx info {};
  if (statx(AT_FDCWD, directory.c_str(), 0, kStatxUniqueMountId | STATX_MNT_ID, &info) == 0) {
    identity.mount =
        absl::StrCat((info.stx_mask & kStatxUniqueMountId) != 0 ? "unique " : "", info.stx_mnt_id,
                     " on ", info.stx_dev_major, ":", info.stx_dev_minor);
  }
  return identity;
}

absl::Status CheckFileSystem(const std::string& directory, bool allow_network_mount,
                             std::string& warning) {
  struct statfs info {};
  if (statfs(directory.c_str(), &info) != 0) {
    return FileError(directory, "its file system cannot be asked", errno);
  }
  std::string network;
  switch (static_cast<std::uint32_t>(info.f_type)) {
    case NFS_SUPER_MAGIC:
      network = "NFS";
      break;
    case SMB_SUPER_MAGIC:
    case kCifsMagic:
    case kSmb2Magic:
      network = "SMB";
      break;
    case FUSE_SUPER_MAGIC:
      network = "FUSE";
      break;
    case TMPFS_MAGIC:
    case RAMFS_MAGIC:
      warning = absl::StrCat(directory,
                             ": is on a file system in memory; what the store keeps ends with the "
                             "machine");
      break;
    default:
      break;
  }
  if (network.empty()) return absl::OkStatus();
  if (allow_network_mount) {
    warning = absl::StrCat(directory, ": is on ", network,
                           ", which may break locks and lose what was synced");
    return absl::OkStatus();
  }
  return Refused(absl::StrCat(directory, ": is on ", network,
                              ", which may break locks and lose what was synced; use a local file "
                              "system, or allow network mounts"),
                 "STORE_ON_NETWORK");
}

absl::StatusOr<DirectoryContent> InspectDirectory(const std::string& directory) {
  std::error_code error;
  const fs::file_status status = fs::status(directory, error);
  if (status.type() == fs::file_type::not_found) return DirectoryContent::kNothing;
  if (error) return FileError(directory, "cannot be read", error.value());
  if (!fs::is_directory(status)) {
    return Refused(absl::StrCat(directory, ": is no directory, must be one of a store, or new"),
                   "STORE_FOREIGN");
  }
  bool has_log = false;
  std::string other;
  for (fs::directory_iterator it(directory, error); !error && it != fs::directory_iterator();
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name == kDatabaseFile) return DirectoryContent::kStore;
    has_log |= name == kLogFile;
    if (!MayBeBesideNoDatabase(name)) other = name;
  }
  if (error) return FileError(directory, "cannot be read", error.value());
  const absl::StatusOr<Head> head = ReadHead(absl::StrCat(directory, "/", kHeadFile));
  if (has_log || (head.ok() && head->last > 0)) {
    return StoreDamaged(absl::StrCat(directory, ": ", kDatabaseFile,
                                     " is missing; restore a backup into another directory"));
  }
  if (!other.empty()) {
    return Refused(absl::StrCat(directory, ": holds '", other,
                                "' and no store; use an empty directory or a new one"),
                   "STORE_FOREIGN");
  }
  return DirectoryContent::kNothing;
}

// The header of the file format: 16 bytes of text at 0, the application's id at 68.
absl::Status CheckDatabaseHeader(const std::string& path) {
  constexpr std::size_t kIdOffset = 68;
  constexpr std::array<char, 16> kText = {"SQLite format 3"};  // with its zero
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return FileError(path, "cannot be opened", errno);
  std::array<char, 100> header{};
  const ssize_t size = pread(file.number(), header.data(), header.size(), 0);
  if (size == static_cast<ssize_t>(header.size()) &&
      std::equal(kText.begin(), kText.end(), header.begin()) &&
      BigEndian(header.data() + kIdOffset) == kApplicationId) {
    return absl::OkStatus();
  }
  return Refused(absl::StrCat(path,
                              ": is no store of cwm, or its first bytes are damaged; use another "
                              "directory, or restore a backup"),
                 "STORE_FOREIGN");
}

void RemoveLeftovers(const std::string& directory) {
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator it(directory, error); !error && it != fs::directory_iterator();
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.starts_with(kBackupPrefix) || name.starts_with(kNewDatabaseFile)) {
      leftovers.push_back(it->path());
    }
  }
  for (const fs::path& path : leftovers) fs::remove_all(path, error);
}

}  // namespace cwm::server
