#include "server/core/fair_quota.h"

#include <gtest/gtest.h>

#include <vector>

namespace cwm::server {
namespace {

ClientId Client(std::int64_t connection, std::uint32_t uid) {
  return {.connection = connection, .uid = uid};
}

// The number of units that a client gets by taking one after the other.
std::int64_t TakeAll(FairQuota& quota, const ClientId& client) {
  std::int64_t taken = 0;
  while (!quota.TryTake(HolderOf(client), 1)) ++taken;
  return taken;
}

TEST(FairQuota, LeavesRoomForNewcomersHoweverManyAreGreedy) {
  FairQuota quota({.limit = 1'000, .member_share = 1});
  // A client may hold as much as it leaves free: client 1 half of the limit. It may also hold as
  // much as its group may still take, which is three times the free amount less what the group
  // holds: client 2 has 200 when 300 are free and the group holds 700.
  EXPECT_EQ(TakeAll(quota, Client(1, 7)), 500);
  EXPECT_EQ(TakeAll(quota, Client(2, 7)), 200);
  EXPECT_GT(TakeAll(quota, Client(3, 7)), 20);
  EXPECT_GT(TakeAll(quota, Client(4, 7)), 5) << "the same user finds room, too";
  for (std::int64_t connection = 5; connection < 100; ++connection) {
    TakeAll(quota, Client(connection, 7));
  }
  EXPECT_GT(TakeAll(quota, Client(100, 8)), 0) << "another user finds room";
}

TEST(FairQuota, SharesAmongUsersFirst) {
  FairQuota quota({.limit = 1'000, .group_share = 1, .member_share = 3});
  std::int64_t of_first_user = 0;
  for (std::int64_t connection = 1; connection < 100; ++connection) {
    of_first_user += TakeAll(quota, Client(connection, 7));
  }
  EXPECT_GE(of_first_user, 499) << "with any number of connections";
  EXPECT_LE(of_first_user, 500);
  EXPECT_GT(TakeAll(quota, Client(100, 8)), 200) << "of 250, some are for its other connections";
}

TEST(FairQuota, SaysWhichLimitRefuses) {
  FairQuota quota({.limit = 100, .member_limit = 10, .group_share = 1, .member_share = 1});
  EXPECT_EQ(quota.TryTake(HolderOf(Client(1, 7)), 101), FairQuota::Refusal::kLimit);
  EXPECT_EQ(quota.TryTake(HolderOf(Client(1, 7)), 11), FairQuota::Refusal::kMember);
  for (std::int64_t connection = 1; connection <= 5; ++connection) {
    EXPECT_FALSE(quota.TryTake(HolderOf(Client(connection, 7)), 10)) << connection;
  }
  EXPECT_EQ(quota.TryTake(HolderOf(Client(6, 7)), 1), FairQuota::Refusal::kGroup);
  EXPECT_FALSE(quota.TryTake(HolderOf(Client(7, 8)), 10));
}

TEST(FairQuota, LeavesAloneAReservedPart) {
  FairQuota quota({.limit = 100, .member_share = 100});
  EXPECT_EQ(quota.TryTake(HolderOf(Client(1, 7)), 31, 70), FairQuota::Refusal::kLimit);
  EXPECT_FALSE(quota.TryTake(HolderOf(Client(1, 7)), 30, 70));
}

TEST(FairQuota, TakesBackWhatSharesHeld) {
  FairQuota quota({.limit = 2, .member_share = 3});
  {
    auto first = QuotaShare::TryTake(quota, Client(1, 7));
    ASSERT_TRUE(first);
    QuotaShare moved = *std::move(first);
    EXPECT_EQ(quota.taken(), 1);
    EXPECT_EQ(quota.taken_by(HolderOf(Client(1, 7))), 1);
  }
  EXPECT_EQ(quota.taken(), 0);
  EXPECT_EQ(quota.taken_by(HolderOf(Client(1, 7))), 0);
}

}  // namespace
}  // namespace cwm::server
