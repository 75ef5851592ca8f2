#include "server/rpc/connections.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <set>
#include <utility>

#include "server/net/peer_uid.h"

namespace cwm::server {
namespace {

constexpr ConnectionLimits kMany = {.all = 1'000, .of_user = 500, .silent_of_user = 100};

// Both ends of a connection.
struct Pair {
  Pair() {
    std::array<int, 2> ends{};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    server = FileDescriptor(ends[0]);
    client = FileDescriptor(ends[1]);
  }
  FileDescriptor server;
  FileDescriptor client;
};

int Register(Connections& connections, Connections::User user, FileDescriptor server) {
  EXPECT_TRUE(connections.TryAdmit(user));
  return connections.Register(std::move(server), user);
}

TEST(ConnectionsTest, EachHasANumberAndAClientOfItsOwn) {
  Connections connections(kMany, 8'192);
  Pair one;
  Pair two;
  const int first = Register(connections, 7, std::move(one.server));
  const int second = Register(connections, 8, std::move(two.server));
  EXPECT_GE(first, 1'024);
  EXPECT_NE(first, second);
  EXPECT_EQ(connections.Find(first), (ClientId{.connection = 1, .uid = 7}));
  EXPECT_EQ(connections.Find(second), (ClientId{.connection = 2, .uid = 8}));
  EXPECT_EQ(connections.Find(1'023).connection, ClientId::kClosed);
  EXPECT_EQ(fcntl(first, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
  close(first);
  close(second);
}

TEST(ConnectionsTest, ANumberIsNotGivenAgainSoon) {
  Connections connections(kMany, 8'192);
  std::set<int> numbers;
  for (int i = 0; i < 1'000; ++i) {
    Pair pair;
    const int number = Register(connections, 7, std::move(pair.server));
    EXPECT_TRUE(numbers.insert(number).second) << number;
    close(number);
    connections.DropClosed();
  }
}

TEST(ConnectionsTest, WhereNumbersAreFewEachStillLeadsToItsLatestConnection) {
  Connections connections(kMany, 64);
  for (int i = 1; i <= 500; ++i) {
    Pair pair;
    const int number = Register(connections, static_cast<std::uint32_t>(i), std::move(pair.server));
    EXPECT_LT(number, 64);
    EXPECT_EQ(connections.Find(number).connection, i);
    EXPECT_EQ(connections.Find(number).uid, static_cast<std::uint32_t>(i));
    close(number);
  }
  connections.DropClosed();
  EXPECT_EQ(connections.open(), 0);
}

TEST(ConnectionsTest, WhatIsClosedIsForgottenThoughSomethingElseLiesAtItsNumber) {
  Connections connections(kMany, 8'192);
  Pair pair;
  const int number = Register(connections, 7, std::move(pair.server));
  connections.DropClosed();
  EXPECT_EQ(connections.open(), 1);
  Pair other;
  ASSERT_EQ(dup2(other.server.number(), number), number);
  connections.DropClosed();
  EXPECT_EQ(connections.open(), 0);
  EXPECT_EQ(connections.Find(number).connection, ClientId::kClosed);
  close(number);
}

TEST(ConnectionsTest, AShutDownMeetsNothingElseThatLiesAtANumber) {
  Connections connections(kMany, 8'192);
  Pair living;
  Pair closed;
  Pair other;
  const int number = Register(connections, 7, std::move(living.server));
  const int reused = Register(connections, 7, std::move(closed.server));
  ASSERT_EQ(dup2(other.server.number(), reused), reused);
  connections.ShutDown(SHUT_RDWR);
  char byte = 0;
  EXPECT_EQ(recv(living.client.number(), &byte, 1, MSG_DONTWAIT), 0) << "shut down";
  EXPECT_EQ(recv(other.client.number(), &byte, 1, MSG_DONTWAIT), -1) << "open";
  close(number);
  close(reused);
}

TEST(ConnectionsTest, NobodyHasMoreThanTheirShareNorAllMoreThanThereIs) {
  Connections connections({.all = 5, .of_user = 3, .silent_of_user = 1}, 8'192);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(connections.TryAdmit(7));
  EXPECT_FALSE(connections.TryAdmit(7));
  EXPECT_TRUE(connections.TryAdmit(8));
  EXPECT_TRUE(connections.TryAdmit(std::nullopt));
  EXPECT_FALSE(connections.TryAdmit(9)) << "there are 5";
  connections.AdmitAlways(9);
  EXPECT_EQ(connections.open(), 6);
  connections.CancelAdmission(9);
  connections.CancelAdmission(8);
  EXPECT_TRUE(connections.TryAdmit(9));
}

TEST(ConnectionsTest, AtALimitThoseThatWereClosedMakeRoomAtOnce) {
  Connections connections({.all = 2, .of_user = 2, .silent_of_user = 1}, 8'192);
  Pair one;
  Pair two;
  close(Register(connections, 7, std::move(one.server)));
  close(Register(connections, 7, std::move(two.server)));
  EXPECT_TRUE(connections.TryAdmit(7));
  EXPECT_EQ(connections.open(), 1);
}

TEST(ConnectionsTest, LimitsFitTheDescriptorsThatThereAre) {
  const auto at = [](std::int64_t descriptors) {
    const auto fitted = ConnectionLimits::Fit(TransportLimits{}, descriptors);
    return std::array{fitted.all, fitted.of_user, fitted.silent_of_user};
  };
  EXPECT_EQ(at(65'536), (std::array<std::int64_t, 3>{4'096, 2'048, 256}));
  EXPECT_EQ(at(1'024), (std::array<std::int64_t, 3>{512, 256, 128}));
  EXPECT_EQ(at(64), (std::array<std::int64_t, 3>{32, 16, 8}));
  EXPECT_EQ(at(1), (std::array<std::int64_t, 3>{1, 1, 1}));
}

TEST(PeerUidTest, TheKernelTellsWhoIsAtTheOtherEndOfAUnixSocketAlone) {
  const Pair pair;
  EXPECT_EQ(PeerUid(pair.server.number()), getuid());
  const FileDescriptor tcp(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(PeerUid(tcp.number()), std::nullopt);
  EXPECT_EQ(PeerUid(-1), std::nullopt);
}

}  // namespace
}  // namespace cwm::server
