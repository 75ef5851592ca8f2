#include "server/rpc/self_check.h"

#include <arpa/inet.h>
#include <grpcpp/create_channel_posix.h>
#include <grpcpp/grpcpp.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "server/core/file_descriptor.h"
#include "server/rpc/end_point.h"
#include "server/rpc/listen_address.h"

namespace cwm::server {
namespace {

EndPoint ToEndPoint(const std::string& text) {
  if (const auto path = SocketPath(text)) return UnixEndPoint(*path);
  const std::size_t colon = text.rfind(':');
  const std::string host = text.substr(0, colon);
  int port = 0;
  if (!absl::SimpleAtoi(text.substr(colon + 1), &port)) return {};
  if (host == "[::1]") return TcpEndPoint(AF_INET6, "", port);
  return TcpEndPoint(AF_INET, host == "localhost" ? "127.0.0.1" : host, port);
}

// Binds our end before it connects, so that its address is known: the kernel picks a port or an
// abstract name.
bool BindOwnEnd(int fd, const EndPoint& peer) {
  EndPoint own;
  own.storage.ss_family = peer.storage.ss_family;
  own.size = peer.size;
  if (peer.storage.ss_family == AF_UNIX) {
    own.size = sizeof(sa_family_t);
  } else if (peer.storage.ss_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6&>(own.storage).sin6_addr = in6addr_loopback;
  } else {
    reinterpret_cast<sockaddr_in&>(own.storage).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  return bind(fd, own.get(), own.size) == 0;
}

std::string OwnAddressOf(int fd) {
  EndPoint own;
  own.size = sizeof(own.storage);
  if (getsockname(fd, own.get(), &own.size) != 0) return {};
  return {reinterpret_cast<const char*>(&own.storage), own.size};
}

absl::Status NotReached(const std::string& address, int error) {
  return absl::UnavailableError(absl::StrCat(address, ": ", std::strerror(error)));
}

// A full backlog of a Unix socket fails with EAGAIN at once: nobody accepts there.
bool Connect(int fd, EndPoint peer, std::chrono::milliseconds timeout) {
  if (connect(fd, peer.get(), peer.size) == 0) return true;
  if (errno != EINPROGRESS) return false;
  pollfd waiting{.fd = fd, .events = POLLOUT, .revents = 0};
  if (poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) {
    errno = ETIMEDOUT;
    return false;
  }
  socklen_t size = sizeof(errno);
  int error = 0;
  getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
  errno = error;
  return error == 0;
}

}  // namespace

absl::Status CheckHealth(const std::string& address, std::chrono::milliseconds timeout,
                         const std::function<void(std::string)>& announce) {
  const auto deadline = std::chrono::system_clock::now() + timeout;
  const EndPoint peer = ToEndPoint(address);
  FileDescriptor connection(
      socket(peer.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!connection.is_open() || !BindOwnEnd(connection.number(), peer)) {
    return NotReached(address, errno);
  }
  if (announce) announce(OwnAddressOf(connection.number()));
  if (!Connect(connection.number(), peer, timeout)) return NotReached(address, errno);
  namespace health = grpc::health::v1;
  const auto stub =
      health::Health::NewStub(grpc::CreateInsecureChannelFromFd(address, connection.Release()));
  grpc::ClientContext context;
  context.set_deadline(deadline);
  health::HealthCheckResponse response;
  const grpc::Status status = stub->Check(&context, {}, &response);
  if (!status.ok())
    return absl::UnavailableError(absl::StrCat(address, ": ", status.error_message()));
  if (response.status() == health::HealthCheckResponse::SERVING) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      address, ": ", health::HealthCheckResponse::ServingStatus_Name(response.status())));
}

}  // namespace cwm::server
