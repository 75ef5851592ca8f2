#include <gtest/gtest.h>

#include <set>

#include "server/core/error.h"
#include "server/core/world_registry.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

TEST(WorldRegistry, TheEmptyNameMeansDefault) {
  WorldRegistry registry({}, {});
  const auto world = registry.FindOrCreate("");
  ASSERT_TRUE(world.ok());
  EXPECT_EQ((*world)->name(), "default");
  EXPECT_EQ(*registry.Find("default"), *world);
  EXPECT_EQ(*registry.Find(""), *world);
  EXPECT_EQ(*registry.FindOrCreate("default"), *world);
}

TEST(WorldRegistry, ListsByName) {
  WorldRegistry registry({}, {});
  for (const char* name : {"c", "a", "b"}) ASSERT_TRUE(registry.FindOrCreate(name).ok());
  std::vector<std::string> names;
  for (const auto& world : registry.List()) names.push_back(world->name());
  EXPECT_EQ(names, (std::vector<std::string>{"a", "b", "c"}));
}

TEST(WorldRegistry, RefusesBadNamesByRule) {
  WorldRegistry registry({}, {});
  EXPECT_TRUE(registry.FindOrCreate("kitchen_2.left-A").ok());
  EXPECT_TRUE(registry.FindOrCreate(std::string(128, 'x')).ok());
  for (const std::string& name : {std::string(129, 'x'), std::string("a b"), std::string("a/b"),
                                  std::string("k\xc3\xbc"), std::string("a\0b", 3)}) {
    const absl::Status status = registry.FindOrCreate(name).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(DetailsOf(status).fields.at(0).field, "world");
  }
  EXPECT_EQ(registry.List().size(), 2u);
}

TEST(WorldRegistry, UnknownWorldsAreNotFound) {
  WorldRegistry registry({}, {});
  const absl::Status status = registry.Find("ghost").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(DetailsOf(status).reason, "WORLD_UNKNOWN");
  EXPECT_EQ(DetailsOf(status).metadata.at("world"), "ghost");
  EXPECT_EQ(DetailsOf(registry.Delete("ghost").status()).reason, "WORLD_UNKNOWN");
}

TEST(WorldRegistry, AWorldMadeAnewHasAnotherUid) {
  WorldRegistry registry({}, {});
  std::set<std::string> uids;
  for (int i = 0; i < 20; ++i) {
    const auto world = registry.FindOrCreate("w");
    ASSERT_TRUE(world.ok());
    EXPECT_EQ((*world)->uid().size(), 32u);
    EXPECT_EQ((*world)->uid().find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_TRUE(uids.insert((*world)->uid()).second);
    ASSERT_TRUE(registry.Delete("w", (*world)->uid()).ok());
  }
}

TEST(WorldRegistry, AUidThatDiffersMeansReplaced) {
  WorldRegistry registry({}, {});
  const std::string uid = (*registry.FindOrCreate("w"))->uid();
  EXPECT_TRUE(registry.Find("w", uid).ok());
  ASSERT_TRUE(registry.Delete("w").ok());
  ASSERT_TRUE(registry.FindOrCreate("w").ok());
  for (const absl::Status& status :
       {registry.Find("w", uid).status(), registry.Delete("w", uid).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_EQ(DetailsOf(status).reason, "WORLD_REPLACED");
  }
  EXPECT_TRUE(registry.Find("w").ok());
}

TEST(WorldRegistry, DeletingClosesTheWorld) {
  WorldRegistry registry({}, {});
  const auto world = registry.FindOrCreate("w");
  ASSERT_TRUE((*world)->Apply(std::vector{Put("a")}, {}).ok());
  ASSERT_TRUE(registry.Delete("w").ok());
  EXPECT_EQ(DetailsOf((*world)->Apply(std::vector{Put("b")}, {}).status()).reason, "WORLD_DELETED");
  EXPECT_EQ(DetailsOf(registry.Find("w").status()).reason, "WORLD_UNKNOWN");
}

TEST(WorldRegistry, AWorldThatNobodyKeepsIsFoundByWritersAloneAndGoesWithTheLast) {
  WorldRegistry registry({}, {});
  std::string uid;
  {
    auto first = registry.AcquireLease("w");
    ASSERT_TRUE(first.ok());
    uid = (*first)->uid();
    {
      auto second = registry.AcquireLease("w");
      ASSERT_TRUE(second.ok());
      EXPECT_EQ(second->world(), first->world());
    }
    EXPECT_FALSE(first->committed());
    EXPECT_EQ(DetailsOf(registry.Find("w").status()).reason, "WORLD_UNKNOWN");
    EXPECT_EQ(DetailsOf(registry.Delete("w").status()).reason, "WORLD_UNKNOWN");
    EXPECT_TRUE(registry.List().empty());
    EXPECT_EQ(DetailsOf(registry.AcquireLease("w", uid).status()).reason, "WORLD_UNKNOWN");
  }
  auto next = registry.AcquireLease("w");
  ASSERT_TRUE(next.ok());
  EXPECT_NE((*next)->uid(), uid) << "the first is gone";
}

TEST(WorldRegistry, AWorldThatOneOfItsWritersKeepsStays) {
  WorldRegistry registry({}, {});
  {
    auto refused = registry.AcquireLease("w");
    {
      auto written = registry.AcquireLease("w");
      ASSERT_TRUE((*written)->Apply(std::vector{Put("a")}, {}).ok());
      EXPECT_TRUE(refused->committed());
    }
  }
  EXPECT_TRUE(registry.Find("w").ok());
}

TEST(WorldRegistry, AWriterOfADeletedWorldDoesNotKeepItsSuccessor) {
  WorldRegistry registry({}, {});
  auto old = registry.AcquireLease("w");
  ASSERT_TRUE((*old)->Apply(std::vector{Put("a")}, {}).ok());
  ASSERT_TRUE(registry.Delete("w").ok());
  {
    auto next = registry.AcquireLease("w");
    EXPECT_EQ(DetailsOf((*old)->Apply(std::vector{Put("b")}, {}).status()).reason, "WORLD_DELETED");
    EXPECT_FALSE(next->committed());
  }
  EXPECT_EQ(DetailsOf(registry.Find("w").status()).reason, "WORLD_UNKNOWN");
}

TEST(WorldRegistry, ARepeatedDeletionGetsTheFirstReplyAndSparesTheSuccessor) {
  Clock::time_point now;
  WorldRegistry registry({}, {}, nullptr, [&now] { return now; });
  ASSERT_TRUE((*registry.FindOrCreate("w"))->Apply(std::vector{Put("a")}, {}).ok());
  const auto first = registry.Delete("w", "", "once");
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(registry.FindOrCreate("w").ok());
  const auto again = registry.Delete("w", "", "once");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->uid, first->uid);
  EXPECT_EQ(again->revision, first->revision);
  EXPECT_TRUE(registry.Find("w").ok());
  EXPECT_EQ(DetailsOf(registry.Delete("w", "another", "once").status()).reason,
            "REQUEST_ID_REUSED");
  EXPECT_EQ(DetailsOf(registry.Delete("elsewhere", "", "once").status()).reason, "WORLD_UNKNOWN")
      << "an id counts within its world";
  now += Retention{}.request_id_time + std::chrono::seconds(1);
  EXPECT_NE(registry.Delete("w", "", "once")->uid, first->uid) << "ids age";
}

TEST(WorldRegistry, HoldsAtMostItsLimit) {
  WorldRegistry registry({.max_worlds = 2}, {});
  ASSERT_TRUE(registry.FindOrCreate("a").ok());
  ASSERT_TRUE(registry.FindOrCreate("b").ok());
  const absl::Status status = registry.FindOrCreate("c").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DetailsOf(status).reason, "TOO_MANY_WORLDS");
  EXPECT_TRUE(registry.FindOrCreate("a").ok());
  ASSERT_TRUE(registry.Delete("a").ok());
  EXPECT_TRUE(registry.FindOrCreate("c").ok());
}

TEST(WorldRegistry, DrainingEndsWatchesAndRefusesNewOnes) {
  WorldRegistry registry({}, {});
  const auto world = *registry.FindOrCreate("w");
  auto watch = *world->Watch({}, [] {});
  ASSERT_TRUE(watch->Next().ok());
  registry.Drain();
  const auto end = watch->Next();
  ASSERT_TRUE(end.ok() && end->has_value());
  EXPECT_TRUE((*end)->last);
  for (const auto& late : {world, *registry.FindOrCreate("new")}) {
    EXPECT_EQ(DetailsOf(late->Watch({}, [] {}).status()).reason, "SERVER_DRAINING");
  }
}

}  // namespace
}  // namespace cwm::server
