// A library for LD_PRELOAD, see disk_faults.h.
#include "tests/fault/disk_faults.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

using cwm::fault::DiskFault;
using cwm::fault::DiskFaults;

// So few bytes are written or not, as the kernel does it within a page.
constexpr std::size_t kWholeBytes = 512;

// nullptr without such a file; nothing fails then.
DiskFaults* MapFaults() {
  const char* const path = std::getenv("CWM_DISK_FAULTS");
  const int file = path == nullptr ? -1 : open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  void* const bytes =
      mmap(nullptr, sizeof(DiskFaults), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  return bytes == MAP_FAILED ? nullptr : static_cast<DiskFaults*>(bytes);
}

DiskFaults* Faults() {
  static DiskFaults* const faults = MapFaults();
  return faults;
}

bool StartsWithPath(const char* path) {
  static const char* const prefix = std::getenv("CWM_DISK_PATH");
  return prefix != nullptr && std::strncmp(path, prefix, std::strlen(prefix)) == 0;
}

bool IsConcerned(int fd) {
  std::array<char, 32> link{};
  std::array<char, 4'096> path{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", fd);
  return readlink(link.data(), path.data(), path.size() - 1) > 0 && StartsWithPath(path.data());
}

// The fault of this call; kNone if it shall succeed.
DiskFault FaultOf(int fd) {
  DiskFaults* const faults = Faults();
  if (faults == nullptr) return DiskFault::kNone;
  const DiskFault fault = faults->fault;
  if (fault == DiskFault::kNone || !IsConcerned(fd)) return DiskFault::kNone;
  return faults->calls_before.fetch_sub(1) > 0 ? DiskFault::kNone : fault;
}

// Counts the call that fails.
int Fail(int error) {
  Faults()->hits.fetch_add(1);
  errno = error;
  return -1;
}

// True if a write up to this offset lies within the file, for which space is never short.
bool IsWithinFile(int fd, off_t end) {
  struct stat file {};
  return fstat(fd, &file) == 0 && end <= file.st_size;
}

int Sync(int fd, long call) {
  const DiskFault fault = FaultOf(fd);
  if (fault == DiskFault::kSyncFails) return Fail(EIO);
  if (fault == DiskFault::kSyncLies) {
    Faults()->hits.fetch_add(1);
    return 0;
  }
  return static_cast<int>(syscall(call, fd));
}

// Calls `write(size)`, or less of it, or fails. `offset` is where it begins.
template <class Write>
ssize_t Written(int fd, std::size_t size, off_t offset, const Write& write) {
  switch (FaultOf(fd)) {
    case DiskFault::kWriteFails:
      return Fail(EIO);
    case DiskFault::kFull:
      return Fail(ENOSPC);
    case DiskFault::kTorn:
      if (IsWithinFile(fd, offset + static_cast<off_t>(size))) return write(size);
      if (Faults()->hits.fetch_add(1) > 0 || size <= kWholeBytes) return Fail(ENOSPC);
      return write(size / 2);
    case DiskFault::kShort:
      if (size <= kWholeBytes) return write(size);
      Faults()->hits.fetch_add(1);
      return write(size / 2);
    default:
      return write(size);
  }
}

bool IsFull() {
  const DiskFaults* const faults = Faults();
  return faults != nullptr &&
         (faults->fault == DiskFault::kFull || faults->fault == DiskFault::kTorn);
}

}  // namespace

extern "C" {

int fsync(int fd) { return Sync(fd, SYS_fsync); }
int fdatasync(int fd) { return Sync(fd, SYS_fdatasync); }

ssize_t write(int fd, const void* data, std::size_t size) {
  const auto call = [&](std::size_t part) { return syscall(SYS_write, fd, data, part); };
  return Written(fd, size, lseek(fd, 0, SEEK_CUR), call);
}

ssize_t pwrite64(int fd, const void* data, std::size_t size, off64_t offset) {
  const auto call = [&](std::size_t part) { return syscall(SYS_pwrite64, fd, data, part, offset); };
  return Written(fd, size, offset, call);
}

ssize_t pwrite(int fd, const void* data, std::size_t size, off_t offset) {
  return pwrite64(fd, data, size, offset);
}

int fallocate(int fd, int mode, off_t offset, off_t size) {
  if (IsFull() && IsConcerned(fd)) return Fail(ENOSPC);
  return static_cast<int>(syscall(SYS_fallocate, fd, mode, offset, size));
}

int posix_fallocate(int fd, off_t offset, off_t size) {
  return fallocate(fd, 0, offset, size) == 0 ? 0 : errno;
}

int posix_fallocate64(int fd, off64_t offset, off64_t size) {
  return posix_fallocate(fd, offset, size);
}

int statvfs(const char* path, struct statvfs* out) noexcept {
  using Function = int (*)(const char*, struct statvfs*);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "statvfs"));
  const int result = next(path, out);
  if (result == 0 && IsFull() && StartsWithPath(path)) out->f_bavail = out->f_bfree = 0;
  return result;
}

int fstatvfs(int fd, struct statvfs* out) noexcept {
  using Function = int (*)(int, struct statvfs*);
  static const auto next = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "fstatvfs"));
  const int result = next(fd, out);
  if (result == 0 && IsFull() && IsConcerned(fd)) out->f_bavail = out->f_bfree = 0;
  return result;
}

}  // extern "C"
