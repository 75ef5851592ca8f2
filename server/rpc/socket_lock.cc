#include "server/rpc/socket_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::server {
namespace {

// chosen: gRPC starts within about 20 ms; on a busy machine in up to a hundred times that.
constexpr auto kPatience = std::chrono::seconds(5);
constexpr auto kPause = std::chrono::milliseconds(5);

int Open(const std::string& path) {
  return open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
}

// True if the opened file is still the one at the path. Its last holder may have removed it, and
// another process created the next.
bool IsFileAt(int fd, const std::string& path) {
  struct stat opened {};
  struct stat there {};
  return fstat(fd, &opened) == 0 && lstat(path.c_str(), &there) == 0 &&
         opened.st_dev == there.st_dev && opened.st_ino == there.st_ino;
}

// Writes our process id for people to read; best effort.
void WriteProcessId(int fd) {
  const std::string pid = absl::StrCat(getpid());
  if (ftruncate(fd, 0) != 0) return;
  [[maybe_unused]] const ssize_t written = pwrite(fd, pid.data(), pid.size(), 0);
}

std::string ProcessIdIn(int fd) {
  std::array<char, 16> text{};  // longer than any pid
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "unknown";
}

absl::Status CannotLock(const std::string& path, const std::string& why) {
  return absl::FailedPreconditionError(absl::StrCat("--listen: cannot lock ", path, ": ", why));
}

// The reason not to use the file as this lock; empty if there is none. A hard link would let us
// overwrite another file of ours.
std::string FaultOf(const struct stat& info) {
  if (!S_ISREG(info.st_mode)) return "it is no regular file; remove it";
  if (info.st_uid != geteuid()) {
    return absl::StrCat("it belongs to user ", info.st_uid, ", must belong to user ", geteuid(),
                        ": remove it, or listen in a directory that others cannot write to");
  }
  if (info.st_nlink > 1) return "it is a hard link to another file; remove it";
  return {};
}

// The error of a file that cannot be opened.
absl::Status CannotOpen(const std::string& path, int error) {
  struct stat info {};
  const std::string fault = lstat(path.c_str(), &info) == 0 ? FaultOf(info) : std::string();
  return CannotLock(path, fault.empty() ? std::strerror(error) : fault);
}

}  // namespace

absl::StatusOr<SocketLock> SocketLock::Acquire(const std::string& socket_path) {
  const std::string path = socket_path + ".lock";
  const auto give_up_at = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    const int fd = Open(path);
    if (fd < 0) return CannotOpen(path, errno);
    SocketLock lock("", fd);  // closes the file
    struct stat info {};
    if (fstat(fd, &info) != 0) return CannotLock(path, std::strerror(errno));
    if (const std::string fault = FaultOf(info); !fault.empty()) return CannotLock(path, fault);
    if (flock(fd, LOCK_EX | LOCK_NB) == 0) {
      if (!IsFileAt(fd, path)) continue;
      WriteProcessId(fd);
      lock.path_ = path;
      return lock;
    }
    if (errno != EWOULDBLOCK && errno != EINTR) return CannotLock(path, std::strerror(errno));
    if (std::chrono::steady_clock::now() > give_up_at) {
      return absl::UnavailableError(
          absl::StrCat("--listen: process ", ProcessIdIn(fd), " holds ", path,
                       " and does not let go of it: is it starting there and stuck?"));
    }
    std::this_thread::sleep_for(kPause);
  }
}

SocketLock::SocketLock(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}

SocketLock::SocketLock(SocketLock&& other) noexcept
    : path_(std::exchange(other.path_, "")), fd_(std::exchange(other.fd_, -1)) {}

// The file is removed before its lock is released, so that a waiting process notices.
SocketLock::~SocketLock() {
  if (fd_ < 0) return;
  if (!path_.empty()) unlink(path_.c_str());
  close(fd_);
}

}  // namespace cwm::server
