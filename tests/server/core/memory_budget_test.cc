#include "server/core/memory_budget.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/core/error.h"
#include "server/core/memory_limit.h"

namespace cwm::server {
namespace {

constexpr std::int64_t kMebibyte = 1 << 20;

MemoryBudget::Payer ClientOf(std::int64_t connection) {
  return MemoryBudget::Client({.connection = connection, .uid = 7});
}

TEST(MemoryBudget, RefusesWithTheAccountThatIsFullAndATimeToRetry) {
  const auto budget = MemoryBudget::Make(100 * kMebibyte);
  auto first = budget->Charge(ClientOf(1), 40 * kMebibyte);
  ASSERT_TRUE(first.ok());
  const absl::Status refused = budget->Charge(ClientOf(1), 40 * kMebibyte).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  const ErrorDetails details = DetailsOf(refused);
  EXPECT_EQ(details.reason, "MEMORY_EXHAUSTED");
  EXPECT_EQ(details.metadata.at("account"), "client");
  EXPECT_TRUE(details.retry_after_s.has_value());
  EXPECT_EQ(DetailsOf(budget->Charge(ClientOf(2), 61 * kMebibyte).status()).metadata.at("account"),
            "server");
  EXPECT_TRUE(budget->Charge(ClientOf(2), 30 * kMebibyte).ok()) << "another finds room";
}

TEST(MemoryBudget, KeepsAQuarterForClientsHoweverFullTheWorldsAre) {
  const auto budget = MemoryBudget::Make(100 * kMebibyte);
  std::vector<MemoryCharge> charges;
  for (int world = 0; world < 20; ++world) {
    const auto payer = MemoryBudget::World(budget->NextWorldNumber(), "w");
    for (;;) {
      auto charge = budget->Charge(payer, kMebibyte / 4);
      if (!charge.ok()) break;
      charges.push_back(*std::move(charge));
    }
  }
  EXPECT_LE(budget->world_bytes(), 75 * kMebibyte);
  EXPECT_GT(budget->world_bytes(), 70 * kMebibyte);
  EXPECT_TRUE(budget->Charge(ClientOf(1), 12 * kMebibyte).ok());
}

TEST(MemoryBudget, LetsOneWorldHaveThreeQuartersOfThemAll) {
  const auto budget = MemoryBudget::Make(1'600 * kMebibyte);
  const auto world = MemoryBudget::World(budget->NextWorldNumber(), "kitchen");
  EXPECT_TRUE(budget->Charge(world, 900 * kMebibyte).ok());
  auto charge = MemoryCharge::Empty(budget, world);
  while (charge.Resize(charge.bytes() + kMebibyte).ok()) {
  }
  EXPECT_EQ(charge.bytes(), 900 * kMebibyte);
  const absl::Status refused = charge.Resize(901 * kMebibyte);
  EXPECT_EQ(DetailsOf(refused).metadata.at("account"), "world");
  EXPECT_NE(refused.message().find("kitchen"), std::string::npos) << refused;
}

TEST(MemoryBudget, ChargesEndWithTheLastReferenceToWhatTheyPayFor) {
  const auto budget = MemoryBudget::Make(100 * kMebibyte);
  auto charge = budget->Charge(ClientOf(1), kMebibyte);
  ASSERT_TRUE(charge.ok());
  std::shared_ptr<const int> object =
      WithCharge(std::make_shared<const int>(3), *std::move(charge));
  std::shared_ptr<const int> reader = object;
  object.reset();
  EXPECT_EQ(budget->client_bytes(), kMebibyte);
  EXPECT_EQ(*reader, 3);
  reader.reset();
  EXPECT_EQ(budget->client_bytes(), 0);
}

TEST(MemoryBudget, ChargesShrinkAndGrowAnyway) {
  const auto budget = MemoryBudget::Make(10 * kMebibyte);
  auto charge = budget->Charge(ClientOf(1), 4 * kMebibyte);
  ASSERT_TRUE(charge.ok());
  ASSERT_TRUE(charge->Resize(3 * kMebibyte).ok());
  EXPECT_EQ(budget->client_bytes(), 3 * kMebibyte);
  EXPECT_FALSE(charge->Resize(20 * kMebibyte).ok());
  EXPECT_EQ(charge->bytes(), 3 * kMebibyte) << "as it was";
  charge->ForceResize(20 * kMebibyte);
  EXPECT_EQ(budget->client_bytes(), 20 * kMebibyte);
  ASSERT_TRUE(charge->Resize(kMebibyte).ok());
  EXPECT_EQ(budget->client_bytes(), kMebibyte);
}

TEST(MemoryLimit, IsPartOfWhatTheMachineHas) {
  EXPECT_GT(DefaultMemoryLimit(), 64 * kMebibyte);
  EXPECT_LE(DefaultMemoryLimit(), AvailableMemory() / 4 * 3);
}

}  // namespace
}  // namespace cwm::server
