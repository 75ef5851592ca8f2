#include "server/rpc/listen_address.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <random>
#include <string_view>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/socket_lock.h"

namespace cwm::server {
namespace {

constexpr std::string_view kUnixPrefix = "unix:";
// The suffix that BindingAddress appends to a path: a dot and so many letters.
constexpr std::size_t kSuffixLetters = 6;
constexpr std::size_t kMaxPathBytes = sizeof(sockaddr_un::sun_path) - 1 - (1 + kSuffixLetters);

bool IsLoopback(const std::string& host) {
  if (host == "localhost" || host == "[::1]") return true;
  in_addr parsed{};
  if (inet_pton(AF_INET, host.c_str(), &parsed) != 1) return false;
  constexpr std::uint32_t kLoopbackNet = 127;
  return (ntohl(parsed.s_addr) >> 24) == kLoopbackNet;
}

sockaddr_un SocketAddress(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

// The process that listens at the other end; empty if the kernel does not report it.
std::optional<pid_t> PeerOf(int fd) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0 || peer.pid <= 0) {
    return std::nullopt;
  }
  return peer.pid;
}

struct Listener {
  bool is_there = false;
  std::optional<pid_t> pid;
};

Listener FindListener(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return {};
  const sockaddr_un address = SocketAddress(path);
  const int result = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  const int error = result == 0 ? 0 : errno;
  const std::optional<pid_t> pid = result == 0 ? PeerOf(fd) : std::nullopt;
  close(fd);
  // A full backlog (EAGAIN) means a server, too. A socket that we may not connect to (EACCES) is
  // judged by its owner.
  return {.is_there = error != ECONNREFUSED && error != ENOENT && error != EACCES, .pid = pid};
}

}  // namespace

std::optional<std::string> SocketPath(const std::string& address) {
  if (!address.starts_with(kUnixPrefix)) return std::nullopt;
  return address.substr(kUnixPrefix.size());
}

absl::StatusOr<std::string> CheckListenAddress(const std::string& address) {
  if (const auto path = SocketPath(address)) {
    if (!path->empty() && path->size() <= kMaxPathBytes) return address;
    return absl::InvalidArgumentError(absl::StrCat("--listen ", address, ": the path has ",
                                                   path->size(), " bytes, must have 1 to ",
                                                   kMaxPathBytes));
  }
  const std::size_t colon = address.rfind(':');
  int port = 0;
  if (colon == std::string::npos || !absl::SimpleAtoi(address.substr(colon + 1), &port) ||
      port < 0 || port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat("--listen ", address, ": must be unix:PATH or HOST:PORT"));
  }
  const std::string host = address.substr(0, colon);
  if (!IsLoopback(host)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--listen ", address, ": ", host.empty() ? "every interface" : host,
                     " is not loopback and the server does not speak TLS yet: listen on unix:PATH, "
                     "127.0.0.1:PORT or [::1]:PORT, and forward from there (ssh -L)"));
  }
  return address;
}

absl::Status CheckVacant(const std::string& address) {
  const auto path = SocketPath(address);
  if (!path) return absl::OkStatus();
  struct stat info {};
  if (lstat(path->c_str(), &info) != 0) return absl::OkStatus();  // no file there
  if (!S_ISSOCK(info.st_mode)) {
    return absl::FailedPreconditionError(
        absl::StrCat("--listen ", address, ": the path exists and is no socket"));
  }
  const std::string owner = info.st_uid == geteuid() ? "" : absl::StrCat(", of user ", info.st_uid);
  if (const Listener listener = FindListener(*path); listener.is_there) {
    return absl::AlreadyExistsError(absl::StrCat(
        "--listen ", address, ": a server is running there already",
        listener.pid ? absl::StrCat(", process ", *listener.pid) : std::string(), owner));
  }
  if (!owner.empty() && geteuid() != 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("--listen ", address, ": a socket lies there", owner,
                     ": listen in a directory that others cannot write to"));
  }
  return absl::OkStatus();
}

std::string BindingAddress(const std::string& address) {
  if (!SocketPath(address)) return address;
  std::random_device random;
  std::uniform_int_distribution<int> letter('a', 'z');
  std::string name = address + ".";
  for (std::size_t i = 0; i < kSuffixLetters; ++i) {
    name.push_back(static_cast<char>(letter(random)));
  }
  return name;
}

absl::Status MoveIntoPlace(const std::string& bound, const std::string& address) {
  if (bound == address) return absl::OkStatus();
  const std::string from = *SocketPath(bound);
  if (rename(from.c_str(), SocketPath(address)->c_str()) == 0) return absl::OkStatus();
  const int error = errno;
  unlink(from.c_str());
  return absl::UnavailableError(
      absl::StrCat("--listen ", address, ": cannot make the socket: ", std::strerror(error)));
}

std::optional<SocketFile> FindSocket(const std::string& address) {
  const auto path = SocketPath(address);
  struct stat info {};
  if (!path || lstat(path->c_str(), &info) != 0 || !S_ISSOCK(info.st_mode)) return std::nullopt;
  return SocketFile{.device = info.st_dev,
                    .inode = info.st_ino,
                    .changed_s = info.st_ctim.tv_sec,
                    .changed_ns = info.st_ctim.tv_nsec};
}

void RemoveSocket(const std::string& address, const SocketFile& own) {
  const auto path = SocketPath(address);
  if (!path) return;
  const auto lock = SocketLock::Acquire(*path);  // so that nobody replaces the socket meanwhile
  if (lock.ok() && FindSocket(address) == own) unlink(path->c_str());
}

}  // namespace cwm::server
