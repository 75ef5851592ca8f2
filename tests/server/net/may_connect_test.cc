#include "server/net/may_connect.h"

#include <gtest/gtest.h>

namespace cwm::server {
namespace {

constexpr std::uint32_t kRoot = 0;
constexpr std::uint32_t kServer = 1000;
constexpr std::uint32_t kOther = 1001;

TEST(MayConnect, TheServersUserAndRootMay) {
  EXPECT_TRUE(MayConnect(kServer, kServer, false));
  EXPECT_TRUE(MayConnect(kRoot, kServer, false));
  EXPECT_TRUE(MayConnect(kRoot, kRoot, false));
}

TEST(MayConnect, OthersAndWhoIsNotKnownMayNot) {
  EXPECT_FALSE(MayConnect(kOther, kServer, false));
  EXPECT_FALSE(MayConnect(kServer, kRoot, false));
  EXPECT_FALSE(MayConnect(std::nullopt, kServer, false));
  EXPECT_FALSE(MayConnect(std::nullopt, kRoot, false));
}

TEST(MayConnect, EverybodyMayWhereTheUserSaidSo) {
  EXPECT_TRUE(MayConnect(kOther, kServer, true));
  EXPECT_TRUE(MayConnect(std::nullopt, kServer, true));
}

}  // namespace
}  // namespace cwm::server
