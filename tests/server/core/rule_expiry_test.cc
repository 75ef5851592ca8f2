// Allowances that expire by themselves, by the real clock. Run under the thread sanitizer.
#include "server/core/rule_expiry.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "server/core/world_registry.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;
using std::chrono::milliseconds;

// Far longer than waking a thread takes, even under a sanitizer on a loaded machine.
constexpr auto kPatience = std::chrono::seconds(20);
// Far longer than the calls before an expiry take there, so that it comes after them.
constexpr auto kSoon = milliseconds(1'000), kLater = milliseconds(2'000);

Change AllowFor(const std::string& a, milliseconds time) {
  return {
      collision::AllowCollision{.pair = {{a}, {"arm"}}, .expires = collision::ExpiryAfter(time)},
      std::nullopt};
}

class RuleExpiryTest : public ::testing::Test {
 protected:
  SnapshotPtr Await(const World& world, std::int64_t revision) {
    const auto at = world.At(AtLeast{{revision}}, Clock::now() + kPatience, {});
    EXPECT_TRUE(at.ok()) << at.status();
    return at.ok() ? *at : world.Snapshot();
  }
  std::shared_ptr<World> Make(const std::string& name) { return *registry.FindOrCreate(name); }

  WorldRegistry registry{{}, {}};
};

TEST_F(RuleExpiryTest, EachEndMakesARevisionWhenItIsDueAndNotBefore) {
  const auto world = Make("w");
  const auto begin = std::chrono::steady_clock::now();
  const auto outcome = world->Apply(std::vector{AllowFor("a", kLater), AllowFor("b", kSoon),
                                                AllowFor("c", std::chrono::hours(1))},
                                    {});
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(Await(*world, 2)->pair_rules().size(), 2u);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, kSoon - milliseconds(10));
  const SnapshotPtr last = Await(*world, 3);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, kLater - milliseconds(10));
  ASSERT_EQ(last->pair_rules().size(), 1u);
  EXPECT_EQ(last->pair_rules()[0].pair.b.name, "c");
  // An earlier snapshot keeps the rules as they were.
  EXPECT_EQ(outcome->snapshot->pair_rules().size(), 3u);
}

TEST_F(RuleExpiryTest, WhatIsAllowedAnewLastsAnewAndWhatIsWithdrawnExpiresNoMore) {
  const auto world = Make("w");
  ASSERT_TRUE(world->Apply(std::vector{AllowFor("a", kSoon)}, {}).ok());
  ASSERT_TRUE(world->Apply(std::vector{AllowFor("a", std::chrono::hours(1))}, {}).ok());
  ASSERT_TRUE(world->Apply(std::vector{AllowFor("b", kSoon)}, {}).ok());
  const Change withdraw{collision::AllowCollision{.pair = {{"arm"}, {"b"}}, .withdraw = true},
                        std::nullopt};
  ASSERT_TRUE(world->Apply(std::vector{withdraw}, {}).ok());
  std::this_thread::sleep_for(kSoon + milliseconds(200));
  EXPECT_EQ(world->Snapshot()->revision(), Revision{4});
  EXPECT_EQ(world->Snapshot()->pair_rules().size(), 1u);
}

TEST_F(RuleExpiryTest, ADeletedWorldExpiresNoMoreAndOthersDo) {
  const auto gone = Make("gone"), other = Make("other");
  ASSERT_TRUE(gone->Apply(std::vector{AllowFor("a", kSoon)}, {}).ok());
  ASSERT_TRUE(other->Apply(std::vector{AllowFor("a", kLater)}, {}).ok());
  ASSERT_TRUE(registry.Delete("gone").ok());
  EXPECT_TRUE(Await(*other, 2)->pair_rules().empty());
  EXPECT_EQ(gone->Snapshot()->revision(), Revision{1});
}

// Simulates a wall clock that is set by an hour after the allowance was accepted.
TEST_F(RuleExpiryTest, AWallClockThatIsSetBackOrForwardChangesNothing) {
  const auto world = Make("w");
  const auto steady_now = std::chrono::steady_clock::now();
  const auto wall_now = std::chrono::system_clock::now();
  constexpr auto kHour = std::chrono::hours(1);
  const auto allow = [&](const std::string& a, milliseconds time, std::chrono::hours wall_ahead) {
    return Change{collision::AllowCollision{
                      .pair = {{a}, {"arm"}},
                      .expires = collision::ExpiryAfter(time, steady_now, wall_now + wall_ahead)},
                  std::nullopt};
  };
  const auto outcome = world->Apply(
      std::vector{allow("set_back", kSoon, kHour), allow("set_forward", kHour, -2 * kHour)}, {});
  ASSERT_TRUE(outcome.ok());
  const SnapshotPtr after = Await(*world, 2);
  EXPECT_GE(std::chrono::steady_clock::now() - steady_now, kSoon);
  ASSERT_EQ(after->pair_rules().size(), 1u);
  EXPECT_EQ(after->pair_rules()[0].pair.b.name, "set_forward");
  EXPECT_EQ(after->pair_rules()[0].expires->wall_time, wall_now - kHour);
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(world->Snapshot()->revision(), Revision{2});
}

TEST_F(RuleExpiryTest, WatchesAreWokenByAnExpiry) {
  const auto world = Make("w");
  ASSERT_TRUE(world->Apply(std::vector{AllowFor("a", kSoon)}, {}).ok());
  std::atomic<int> wakes = 0;
  const auto watch = world->Watch({.from_revision = Revision{1}}, [&] { ++wakes; });
  Await(*world, 2);
  const auto step = (*watch)->Next();
  ASSERT_TRUE(step.ok() && step->has_value());
  ASSERT_EQ((*step)->rule_deltas.size(), 1u);
  EXPECT_TRUE((*step)->rule_deltas[0].after.IsEmpty());
  for (const auto end = Clock::now() + kPatience; wakes == 0 && Clock::now() < end;) {
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_EQ(wakes, 1);
}

TEST(RuleExpiry, IsRightForWritersThatRaceWithItAndEndsWithThem) {
  std::shared_ptr<World> world;
  {
    WorldRegistry registry{{}, {}};
    world = *registry.FindOrCreate("w");
    std::vector<std::thread> writers;
    for (int w = 0; w < 3; ++w) {
      writers.emplace_back([&, w] {
        for (int i = 0; i < 50; ++i) {
          const std::string name = std::to_string(w) + "_" + std::to_string(i);
          EXPECT_TRUE(world->Apply(std::vector{AllowFor(name, milliseconds(i % 10))}, {}).ok());
        }
      });
    }
    for (std::thread& writer : writers) writer.join();
    for (const auto end = Clock::now() + kPatience;
         !world->Snapshot()->pair_rules().empty() && Clock::now() < end;) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    EXPECT_TRUE(world->Snapshot()->pair_rules().empty());
    ASSERT_TRUE(world->Apply(std::vector{AllowFor("late", milliseconds(20))}, {}).ok());
  }
  // The registry is gone but the world still exists: it accepts changes, and nothing expires.
  std::this_thread::sleep_for(milliseconds(60));
  ASSERT_TRUE(world->Apply(std::vector{AllowFor("later", milliseconds(20))}, {}).ok());
}

TEST(RuleExpiry, TellsAgainAWorldOfWhichNothingWasOver) {
  using std::chrono::seconds;
  const auto at = [](int s) { return Clock::time_point(seconds(s)); };
  std::atomic<int> clock_s = 50;
  const auto expiry = std::make_shared<RuleExpiry>([&] { return at(clock_s.load()); });
  const auto world =
      std::make_shared<World>("w", "uid", Retention{}, Clock::now, WorldServices{.expiry = expiry});
  const Change change{
      collision::AllowCollision{.pair = {{"a"}, {"arm"}},
                                .expires = collision::Expiry{.due = at(100), .wall_time = {}}},
      std::nullopt};
  ASSERT_TRUE(world->Apply(std::vector{change}, {}).ok());
  expiry->Set("uid", world, at(50));  // too early
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(world->Snapshot()->revision(), Revision{1});
  clock_s = 100;
  expiry->Set("another", {}, at(1'000));  // wakes it
  EXPECT_TRUE(world->At(AtLeast{{2}}, Clock::now() + kPatience, {}).ok());
  EXPECT_TRUE(world->Snapshot()->pair_rules().empty());
  expiry->Stop();
}

}  // namespace
}  // namespace cwm::server
