#include "server/rpc/listener.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/end_point.h"
#include "server/rpc/listen_address.h"

namespace cwm::server {
namespace {

// chosen: with port 0, the port picked for the first address may be taken at the second.
constexpr int kMaxPortAttempts = 16;

absl::Status CannotListen(const std::string& address, int error) {
  return absl::UnavailableError(
      absl::StrCat("--listen ", address, ": cannot listen: ", std::strerror(error)));
}

// Invalid, with errno set, if the socket cannot be created.
FileDescriptor MakeSocket(const EndPoint& address, std::chrono::milliseconds user_timeout) {
  FileDescriptor made(socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made.is_open()) return made;
  const int on = 1;
  const auto timeout_ms = static_cast<unsigned>(user_timeout.count());
  const int fd = made.number();
  if (address.family() == AF_UNIX) {
    fchmod(fd, 0600);  // the file created by bind gets the socket's mode
  } else {
    // Accepted connections inherit these options.
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &timeout_ms, sizeof(timeout_ms));
  }
  if (address.family() == AF_INET6) {
    setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &on, sizeof(on));
  }
  if (bind(fd, address.get(), address.size) == 0 && listen(fd, SOMAXCONN) == 0) return made;
  const int error = errno;
  if (address.family() == AF_UNIX) {
    unlink(reinterpret_cast<const sockaddr_un&>(address.storage).sun_path);
  }
  made.Close();
  errno = error;
  return made;
}

int PortOf(const FileDescriptor& socket) {
  EndPoint address;
  address.size = sizeof(address.storage);
  getsockname(socket.number(), address.get(), &address.size);
  // The port is at the same offset in both address families.
  return ntohs(reinterpret_cast<const sockaddr_in&>(address.storage).sin_port);
}

absl::StatusOr<ListeningSockets> ListenUnix(const std::string& address) {
  const std::string binding = BindingAddress(address);
  ListeningSockets listener{.address = address, .sockets = {}};
  listener.sockets.push_back(MakeSocket(UnixEndPoint(*SocketPath(binding)), {}));
  if (!listener.sockets.front().is_open()) return CannotListen(address, errno);
  if (auto status = MoveIntoPlace(binding, address); !status.ok()) return status;
  return listener;
}

// True if the error means that IPv6 is absent or disabled.
bool IsNoSuchAddress(int error) { return error == EAFNOSUPPORT || error == EADDRNOTAVAIL; }

absl::StatusOr<ListeningSockets> ListenLocalhost(const std::string& address, int port,
                                                 std::chrono::milliseconds user_timeout) {
  for (int attempt = 1;; ++attempt) {
    ListeningSockets listener;
    auto first = MakeSocket(TcpEndPoint(AF_INET, "127.0.0.1", port), user_timeout);
    if (!first.is_open()) return CannotListen(address, errno);
    const int picked = PortOf(first);
    listener.sockets.push_back(std::move(first));
    listener.address = absl::StrCat("localhost:", picked);
    auto second = MakeSocket(TcpEndPoint(AF_INET6, "", picked), user_timeout);
    if (second.is_open()) {
      listener.sockets.push_back(std::move(second));
      return listener;
    }
    if (IsNoSuchAddress(errno)) return listener;
    if (port != 0 || errno != EADDRINUSE || attempt == kMaxPortAttempts) {
      return CannotListen(address, errno);
    }
  }
}

}  // namespace

absl::StatusOr<ListeningSockets> Listen(const std::string& address,
                                        std::chrono::milliseconds user_timeout) {
  if (SocketPath(address)) return ListenUnix(address);
  const std::size_t colon = address.rfind(':');
  const std::string host = address.substr(0, colon);
  int port = 0;
  if (!absl::SimpleAtoi(address.substr(colon + 1), &port)) return CannotListen(address, EINVAL);
  if (host == "localhost") return ListenLocalhost(address, port, user_timeout);
  const int family = host == "[::1]" ? AF_INET6 : AF_INET;
  ListeningSockets listener;
  listener.sockets.push_back(MakeSocket(TcpEndPoint(family, host, port), user_timeout));
  if (!listener.sockets.front().is_open()) return CannotListen(address, errno);
  listener.address = absl::StrCat(host, ":", PortOf(listener.sockets.front()));
  return listener;
}

}  // namespace cwm::server
