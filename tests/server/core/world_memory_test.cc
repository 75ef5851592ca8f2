// Worlds are charged for their memory and give it back.
#include <gtest/gtest.h>

#include "server/core/error.h"
#include "server/core/world_registry.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

constexpr std::int64_t kMebibyte = 1 << 20;

class WorldMemoryTest : public ::testing::Test {
 protected:
  // Puts objects one by one until one is refused or all are put; returns the last status.
  absl::Status PutMany(World& world, int count, const std::string& stem = "box_", double x_m = 0) {
    for (int i = 0; i < count; ++i) {
      const collision::Change put = Put(stem + std::to_string(i), x_m);
      if (auto done = world.Apply({&put, 1}, {}); !done.ok()) return done.status();
    }
    return absl::OkStatus();
  }

  std::shared_ptr<MemoryBudget> memory_ = MemoryBudget::Make(4 * kMebibyte);
  Limits limits_{.max_objects = 100};
  WorldRegistry registry_{limits_, {}, memory_};
};

TEST_F(WorldMemoryTest, IsChargedWithItsObjectsAndGivenBackWhenItGoes) {
  {
    const auto world = registry_.FindOrCreate("w");
    ASSERT_TRUE(world.ok());
    const std::int64_t empty = memory_->world_bytes();
    ASSERT_TRUE(PutMany(**world, 10).ok());
    EXPECT_GT(memory_->world_bytes(), empty + 10 * 1'000);
    EXPECT_EQ((*world)->memory_bytes(), memory_->world_bytes());
    ASSERT_TRUE(registry_.Delete("w").ok());
  }
  EXPECT_EQ(memory_->world_bytes(), 0);
}

TEST_F(WorldMemoryTest, ForgetsItsPastBeforeItRefusesWhatComes) {
  const auto world = registry_.FindOrCreate("w");
  ASSERT_TRUE(world.ok());
  ASSERT_TRUE(PutMany(**world, 50).ok());
  // Objects of the same names are replaced again and again; the replaced ones belong to the past.
  for (int round = 0; round < 200; ++round) {
    ASSERT_TRUE(PutMany(**world, 50, "box_", round).ok()) << round;
  }
  EXPECT_GT((*world)->oldest_exact().value, 1);
  EXPECT_EQ((*world)->Snapshot()->objects().size(), 50u);
}

TEST_F(WorldMemoryTest, TakesThePastOfOtherWorldsToo) {
  const auto memory = MemoryBudget::Make(kMebibyte / 2);
  WorldRegistry registry({}, {}, memory);
  const auto first = registry.FindOrCreate("first");
  const auto second = registry.FindOrCreate("second");
  ASSERT_TRUE(first.ok() && second.ok());
  // The first world's history takes as much memory as allowed.
  ASSERT_TRUE(PutMany(**first, 10).ok());
  for (int i = 0; (*first)->oldest_exact().value == 0; ++i) {
    ASSERT_TRUE(PutMany(**first, 10, "box_", i).ok()) << i;
  }
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(PutMany(**first, 10, "box_", -i).ok()) << i;
  const collision::Revision kept = (*first)->oldest_exact();
  ASSERT_LT(kept, (*first)->Snapshot()->revision());
  // In the end the second world uses more memory than was free before.
  PutMany(**second, 1'000).IgnoreError();
  EXPECT_EQ((*first)->oldest_exact(), (*first)->Snapshot()->revision());
  EXPECT_EQ((*first)->Snapshot()->objects().size(), 10u) << "and nothing of the present";
  EXPECT_GT((*second)->Snapshot()->objects().size(), 50u);
}

TEST_F(WorldMemoryTest, RefusesObjectsBeyondTheAccountAndStaysAsItWas) {
  const auto memory = MemoryBudget::Make(kMebibyte / 4);
  WorldRegistry registry({}, {}, memory);
  const auto world = registry.FindOrCreate("w");
  ASSERT_TRUE(world.ok());
  const absl::Status refused = PutMany(**world, 1'000);
  EXPECT_EQ(DetailsOf(refused).reason, "MEMORY_EXHAUSTED") << refused;
  EXPECT_TRUE(DetailsOf(refused).retry_after_s.has_value());
  const std::size_t count = (*world)->Snapshot()->objects().size();
  EXPECT_GT(count, 5u);
  EXPECT_LE(memory->world_bytes(), memory->limit_bytes());
  // Freed memory can be reused once the history that holds it was dropped, except for the newest
  // event.
  for (const char* name : {"box_0", "box_1"}) {
    const collision::Change remove = Remove(name);
    ASSERT_TRUE((*world)->Apply({&remove, 1}, {}).ok());
  }
  EXPECT_TRUE(PutMany(**world, 1, "other_").ok());
  EXPECT_EQ((*world)->Snapshot()->objects().size(), count - 1);
}

TEST_F(WorldMemoryTest, RefusesMoreObjectsThanAWorldMayHave) {
  const auto world = registry_.FindOrCreate("w");
  ASSERT_TRUE(world.ok());
  ASSERT_TRUE(PutMany(**world, 100).ok());
  const absl::Status refused = PutMany(**world, 1, "one_too_many_");
  EXPECT_EQ(DetailsOf(refused).reason, "TOO_MANY_OBJECTS") << refused;
  EXPECT_TRUE(PutMany(**world, 100).ok()) << "anew, which makes no more of them";
}

}  // namespace
}  // namespace cwm::server
