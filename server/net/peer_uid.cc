#include "server/net/peer_uid.h"

#include <arpa/inet.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace cwm::server {
namespace {

constexpr int kMaxWait_ms = 100;

// One end of a TCP connection, in network byte order. An IPv4-mapped IPv6 address
// (::ffff:127.0.0.1) is stored as IPv4.
struct Endpoint {
  int family = AF_UNSPEC;
  std::array<std::uint32_t, 4> address{};  // one word of IPv4, four of IPv6
  std::uint16_t port = 0;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

Endpoint MakeEndpoint(int family, const void* address, std::uint16_t port) {
  Endpoint endpoint{.family = family, .port = port};
  in6_addr v6{};
  std::memcpy(&v6, address, family == AF_INET ? sizeof(in_addr) : sizeof(in6_addr));
  if (family == AF_INET) {
    std::memcpy(endpoint.address.data(), &v6, sizeof(in_addr));
  } else if (IN6_IS_ADDR_V4MAPPED(&v6)) {
    endpoint.family = AF_INET;
    std::memcpy(endpoint.address.data(), &v6.s6_addr[12], sizeof(in_addr));
  } else {
    std::memcpy(endpoint.address.data(), &v6, sizeof(in6_addr));
  }
  return endpoint;
}

using NameFunction = int (*)(int, sockaddr*, socklen_t*);

std::optional<Endpoint> EndpointOf(int fd, NameFunction name) {
  sockaddr_storage storage{};
  socklen_t size = sizeof(storage);
  if (name(fd, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return std::nullopt;
  if (storage.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(storage);
    return MakeEndpoint(AF_INET, &v4.sin_addr, v4.sin_port);
  }
  if (storage.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(storage);
    return MakeEndpoint(AF_INET6, &v6.sin6_addr, v6.sin6_port);
  }
  return std::nullopt;
}

bool IsLoopback(const Endpoint& endpoint) {
  if (endpoint.family == AF_INET) {
    constexpr std::uint32_t kLoopbackNet = 127;
    return ntohl(endpoint.address[0]) >> 24 == kLoopbackNet;
  }
  return endpoint.family == AF_INET6 &&
         std::memcmp(endpoint.address.data(), &in6addr_loopback, sizeof(in6_addr)) == 0;
}

struct Request {
  nlmsghdr header;
  inet_diag_req_v2 body;
};

// A request for the socket that is bound to `local` and connected to `remote`.
Request MakeRequest(const Endpoint& local, const Endpoint& remote) {
  Request request{};
  request.header.nlmsg_len = sizeof(request);
  request.header.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  request.header.nlmsg_flags = NLM_F_REQUEST;
  request.body.sdiag_family = static_cast<__u8>(local.family);
  request.body.sdiag_protocol = IPPROTO_TCP;
  request.body.idiag_states = ~0U;
  inet_diag_sockid& id = request.body.id;
  id.idiag_sport = local.port;
  id.idiag_dport = remote.port;
  std::copy(local.address.begin(), local.address.end(), id.idiag_src);
  std::copy(remote.address.begin(), remote.address.end(), id.idiag_dst);
  id.idiag_cookie[0] = INET_DIAG_NOCOOKIE;
  id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  return request;
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  const int fd_;
};

// The kernel's description of the socket; empty if it has none or does not answer in time.
std::optional<inet_diag_msg> Describe(const Request& request) {
  const Descriptor netlink(
      socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_SOCK_DIAG));
  if (netlink.get() < 0) return std::nullopt;
  sockaddr_nl kernel{};
  kernel.nl_family = AF_NETLINK;
  if (sendto(netlink.get(), &request, sizeof(request), 0,
             reinterpret_cast<const sockaddr*>(&kernel), sizeof(kernel)) != sizeof(request)) {
    return std::nullopt;
  }
  pollfd ready{.fd = netlink.get(), .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, kMaxWait_ms) != 1) return std::nullopt;
  constexpr std::size_t kReplyBytes = 1024;  // a description with attributes has about 120
  alignas(nlmsghdr) std::array<char, kReplyBytes> reply{};
  sockaddr_nl sender{};
  socklen_t sender_size = sizeof(sender);
  const ssize_t size = recvfrom(netlink.get(), reply.data(), reply.size(), 0,
                                reinterpret_cast<sockaddr*>(&sender), &sender_size);
  if (size < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(inet_diag_msg))) || sender.nl_pid != 0) {
    return std::nullopt;
  }
  nlmsghdr header{};
  std::memcpy(&header, reply.data(), sizeof(header));
  if (header.nlmsg_type != SOCK_DIAG_BY_FAMILY) return std::nullopt;
  inet_diag_msg message{};
  std::memcpy(&message, reply.data() + NLMSG_HDRLEN, sizeof(message));
  return message;
}

std::optional<std::uint32_t> UidOfLoopbackPeer(int fd) {
  const auto own = EndpointOf(fd, getsockname);
  const auto peer = EndpointOf(fd, getpeername);
  if (!own || !peer || !IsLoopback(*own) || !IsLoopback(*peer)) return std::nullopt;
  const auto found = Describe(MakeRequest(*peer, *own));
  if (!found) return std::nullopt;
  // If the connection is gone, the kernel returns a listener on the peer's port, whoever owns it.
  const inet_diag_sockid& id = found->id;
  if (MakeEndpoint(found->idiag_family, id.idiag_src, id.idiag_sport) != *peer ||
      MakeEndpoint(found->idiag_family, id.idiag_dst, id.idiag_dport) != *own) {
    return std::nullopt;
  }
  // A socket without a file reports user 0. The kernel reads the inode after the user, so a socket
  // that is closed in between has no inode either.
  if (found->idiag_inode == 0) return std::nullopt;
  return found->idiag_uid;
}

std::optional<std::uint32_t> UidOfUnixPeer(int fd) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return std::nullopt;
  if (peer.uid == static_cast<uid_t>(-1)) return std::nullopt;
  return peer.uid;
}

}  // namespace

std::optional<std::uint32_t> PeerUid(int fd) {
  int family = AF_UNSPEC;
  socklen_t size = sizeof(family);
  if (getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &family, &size) != 0) return std::nullopt;
  if (family == AF_UNIX) return UidOfUnixPeer(fd);
  return UidOfLoopbackPeer(fd);
}

}  // namespace cwm::server
