#include "server/net/peer_uid.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <string>
#include <utility>

#include "tests/support/other_user.h"
#include "tests/support/process.h"

namespace cwm::server {
namespace {

using testing::kNobody;
using testing::OtherUser;

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&&) = delete;
  ~Socket() { Close(); }
  void Close() {
    if (fd_ >= 0) close(std::exchange(fd_, -1));
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  int family() const { return storage.ss_family; }
};

Address InternetAddress(const std::string& host, std::uint16_t port) {
  Address address;
  if (host.find(':') == std::string::npos) {
    auto& v4 = reinterpret_cast<sockaddr_in&>(address.storage);
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    address.size = sizeof(v4);
    EXPECT_EQ(inet_pton(AF_INET, host.c_str(), &v4.sin_addr), 1);
  } else {
    auto& v6 = reinterpret_cast<sockaddr_in6&>(address.storage);
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    address.size = sizeof(v6);
    EXPECT_EQ(inet_pton(AF_INET6, host.c_str(), &v6.sin6_addr), 1);
  }
  return address;
}

Address UnixAddress(const std::string& path) {
  Address address;
  auto& name = reinterpret_cast<sockaddr_un&>(address.storage);
  name.sun_family = AF_UNIX;
  std::strncpy(name.sun_path, path.c_str(), sizeof(name.sun_path) - 1);
  address.size = sizeof(name);
  return address;
}

Socket Listen(const Address& address) {
  Socket listener(socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int off = 0;
  if (address.family() == AF_INET6) {
    setsockopt(listener.fd(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof(off));
  }
  EXPECT_EQ(bind(listener.fd(), address.get(), address.size), 0) << std::strerror(errno);
  EXPECT_EQ(listen(listener.fd(), 8), 0);
  return listener;
}

std::uint16_t PortOf(const Socket& socket) {
  sockaddr_storage storage{};
  socklen_t size = sizeof(storage);
  EXPECT_EQ(getsockname(socket.fd(), reinterpret_cast<sockaddr*>(&storage), &size), 0);
  return ntohs(reinterpret_cast<const sockaddr_in&>(storage).sin_port);  // same place in IPv6
}

// Returns -1 if the protocol is not available.
int Connect(const Address& address, int protocol = 0) {
  const int fd = socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC, protocol);
  if (fd >= 0 && connect(fd, address.get(), address.size) != 0) {
    close(fd);
    return -1;
  }
  return fd;
}

Socket Accept(const Socket& listener) { return Socket(accept(listener.fd(), nullptr, nullptr)); }

// A way in which a peer connects to a listener.
struct Way {
  std::string name;
  std::string bound;
  std::string dialed;
  int protocol = 0;
};

class PeerUidOverTcp : public ::testing::TestWithParam<Way> {
 protected:
  Socket listener_ = Listen(InternetAddress(GetParam().bound, 0));
  Address address_ = InternetAddress(GetParam().dialed, PortOf(listener_));
};

TEST_P(PeerUidOverTcp, IsOursForASocketOfOurs) {
  const Socket peer(Connect(address_, GetParam().protocol));
  if (peer.fd() < 0) GTEST_SKIP() << "this kernel does not have " << GetParam().name;
  EXPECT_EQ(PeerUid(Accept(listener_).fd()), geteuid());
}

TEST_P(PeerUidOverTcp, IsThatOfAnotherUser) {
  if (!testing::CanBecomeOtherUser()) GTEST_SKIP() << "only root can become another user";
  if (Socket(Connect(address_, GetParam().protocol)).fd() < 0) {
    GTEST_SKIP() << "this kernel does not have " << GetParam().name;
  }
  Accept(listener_);
  OtherUser stranger(kNobody, [&]() -> std::string {
    if (Connect(address_, GetParam().protocol) >= 0) pause();
    return "";
  });
  const Socket accepted = Accept(listener_);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(PeerUid(accepted.fd()), kNobody);
}

INSTANTIATE_TEST_SUITE_P(
    Ways, PeerUidOverTcp,
    ::testing::Values(Way{"IPv4", "127.0.0.1", "127.0.0.1"},
                      Way{"AnotherAddressOfLoopback", "0.0.0.0", "127.1.2.3"},
                      Way{"IPv6", "::1", "::1"}, Way{"IPv4ToASocketOfIPv6", "::", "127.0.0.1"},
                      Way{"IPv4FromASocketOfIPv6", "127.0.0.1", "::ffff:127.0.0.1"},
                      Way{"MappedOnBothSides", "::", "::ffff:127.0.0.1"},
                      Way{"MultipathTcp", "127.0.0.1", "127.0.0.1", IPPROTO_MPTCP}),
    [](const auto& info) { return info.param.name; });

TEST(PeerUid, IsThatOfTheUserAtAUnixSocket) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "socket";
  const Socket listener = Listen(UnixAddress(path));
  {
    const Socket peer(Connect(UnixAddress(path)));
    EXPECT_EQ(PeerUid(Accept(listener).fd()), geteuid());
  }
  if (!testing::CanBecomeOtherUser()) GTEST_SKIP() << "only root can become another user";
  ASSERT_EQ(chmod(scratch.path().c_str(), 0755), 0);
  ASSERT_EQ(chmod(path.c_str(), 0666), 0);
  OtherUser stranger(kNobody, [&]() -> std::string {
    if (Connect(UnixAddress(path)) >= 0) pause();
    return "";
  });
  EXPECT_EQ(PeerUid(Accept(listener).fd()), kNobody);
}

// The kernel reports user 0 for a closed socket; a stranger would be taken for root.
TEST(PeerUid, IsUnknownWhenThePeerHasClosedItsSocket) {
  const Socket listener = Listen(InternetAddress("127.0.0.1", 0));
  Socket peer(Connect(InternetAddress("127.0.0.1", PortOf(listener))));
  const Socket accepted = Accept(listener);
  ASSERT_EQ(PeerUid(accepted.fd()), geteuid());
  peer.Close();
  EXPECT_EQ(PeerUid(accepted.fd()), std::nullopt);
}

TEST(PeerUid, StaysKnownWhileThePeerHasClosedOneDirectionOnly) {
  const Socket listener = Listen(InternetAddress("127.0.0.1", 0));
  const Socket peer(Connect(InternetAddress("127.0.0.1", PortOf(listener))));
  const Socket accepted = Accept(listener);
  ASSERT_EQ(shutdown(peer.fd(), SHUT_WR), 0);
  EXPECT_EQ(PeerUid(accepted.fd()), geteuid());
}

// The peer's half of the connection disappears a minute after it was closed, while ours stays;
// TCP_REPAIR removes it at once. The kernel then returns the listener on the peer's port, whoever
// owns it.
TEST(PeerUid, IsNotThatOfAListenerOnThePeersPort) {
  const Socket listener = Listen(InternetAddress("127.0.0.1", 0));
  Socket peer(Connect(InternetAddress("127.0.0.1", PortOf(listener))));
  const std::uint16_t port = PortOf(peer);
  const Socket accepted = Accept(listener);
  const int on = 1;
  if (setsockopt(peer.fd(), IPPROTO_TCP, TCP_REPAIR, &on, sizeof(on)) != 0) {
    GTEST_SKIP() << "only an administrator of the network can take a connection away";
  }
  peer.Close();
  const Socket next = Listen(InternetAddress("127.0.0.1", port));
  EXPECT_EQ(PeerUid(accepted.fd()), std::nullopt);
}

TEST(PeerUid, IsUnknownForWhatIsNoConnection) {
  EXPECT_EQ(PeerUid(-1), std::nullopt);
  EXPECT_EQ(PeerUid(STDERR_FILENO), std::nullopt);
  const Socket listener = Listen(InternetAddress("127.0.0.1", 0));
  EXPECT_EQ(PeerUid(listener.fd()), std::nullopt);
}

}  // namespace
}  // namespace cwm::server
