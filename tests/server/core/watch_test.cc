// Tests watches against etcd's guarantees: ordered, unique, reliable, atomic, resumable,
// bookmarkable.
#include "server/core/watch.h"

#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/world.h"
#include "tests/server/core/fake_clock.h"
#include "tests/server/core/replica.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;
using Kind = WatchStep::Kind;

class WatchTest : public ::testing::Test {
 protected:
  void Write(std::vector<Change> changes) {
    const auto outcome = world.Apply(changes, {});
    ASSERT_TRUE(outcome.ok()) << outcome.status();
  }
  std::unique_ptr<WatchCursor> MustWatch(const WatchOptions& options = {}) {
    auto watch = world.Watch(options, [this] { ++wakes; });
    EXPECT_TRUE(watch.ok()) << watch.status();
    return *std::move(watch);
  }
  static WatchStep MustStep(WatchCursor& watch) {
    const auto step = watch.Next();
    EXPECT_TRUE(step.ok()) << step.status();
    EXPECT_TRUE(step.ok() && step->has_value()) << "there is nothing to read";
    return step.ok() ? step->value_or(WatchStep{}) : WatchStep{};
  }
  static void ExpectNothing(WatchCursor& watch) {
    const auto step = watch.Next();
    ASSERT_TRUE(step.ok()) << step.status();
    EXPECT_FALSE(step->has_value());
  }

  FakeClock clock;
  World world{
      "w", "uid", {.exact_snapshots = 4, .recent_snapshots = 0, .watch_events = 8}, clock.now()};
  int wakes = 0;
};

TEST_F(WatchTest, BeginsWithTheWholeWorld) {
  Write({Put("a"), Put("b")});
  const auto watch = MustWatch();
  const WatchStep step = MustStep(*watch);
  EXPECT_EQ(step.kind, Kind::kInitialState);
  EXPECT_EQ(step.revision, Revision{1});
  EXPECT_EQ(NamesIn(*step.snapshot), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(watch->position(), Revision{1});
  ExpectNothing(*watch);
}

TEST_F(WatchTest, LosslessDeliversEveryRevisionWholeAndInOrder) {
  const auto watch = MustWatch();
  MustStep(*watch);
  Write({Put("a"), Put("b")});
  Write({Move("a", 1)});
  Write({Remove("b"), Put("c")});
  for (int r = 1; r <= 3; ++r) {
    const WatchStep step = MustStep(*watch);
    EXPECT_EQ(step.kind, Kind::kEvents);
    EXPECT_EQ(step.revision, Revision{r});
    EXPECT_EQ(step.deltas.size(), r == 2 ? 1u : 2u);
    EXPECT_EQ(watch->position(), Revision{r});
  }
  ExpectNothing(*watch);
}

TEST_F(WatchTest, CoalescedTellsTheNewestOfEachObjectAndNoDeleteIsLost) {
  Write({Put("a"), Put("b"), Put("kept")});
  const auto watch = MustWatch({.mode = WatchMode::kCoalesced});
  MustStep(*watch);
  for (int i = 1; i <= 20; ++i) Write({Move("a", i)});
  Write({Remove("b")});
  Write({Put("c")});
  const WatchStep step = MustStep(*watch);
  EXPECT_EQ(step.kind, Kind::kEvents);
  EXPECT_EQ(step.revision, world.Snapshot()->revision());
  ASSERT_EQ(step.deltas.size(), 3u);
  EXPECT_EQ(step.deltas[0].after->X_WO.translation().x(), 20);
  EXPECT_EQ(step.deltas[1].before->name, "b");
  EXPECT_EQ(step.deltas[1].after, nullptr);
  EXPECT_EQ(step.deltas[2].after->name, "c");
  ExpectNothing(*watch);
}

TEST_F(WatchTest, CoalescedMovesOnByABookmarkWhenAllIsAsItWas) {
  Write({Put("a")});
  const auto watch = MustWatch({.mode = WatchMode::kCoalesced});
  MustStep(*watch);
  Write({Put("brief")});
  Write({Remove("brief")});
  const WatchStep step = MustStep(*watch);
  EXPECT_EQ(step.kind, Kind::kBookmark);
  EXPECT_FALSE(step.last);
  EXPECT_EQ(step.revision, Revision{3});
}

// An object that is removed and put again is a different one, so both events must be reported.
TEST_F(WatchTest, CoalescedTellsAnObjectThatWasMadeAnew) {
  Write({Put("a")});
  const auto watch = MustWatch({.mode = WatchMode::kCoalesced});
  MustStep(*watch);
  Write({Remove("a")});
  Write({Put("a")});
  const WatchStep step = MustStep(*watch);
  ASSERT_EQ(step.deltas.size(), 2u);
  EXPECT_EQ(step.deltas[0].after, nullptr);
  EXPECT_EQ(step.deltas[1].before, nullptr);
  EXPECT_NE(step.deltas[0].before->Uid(), step.deltas[1].after->Uid());
}

TEST_F(WatchTest, ResumesAfterAnyKeptRevisionInBothModes) {
  // Copies, since a snapshot that is held is also kept.
  const auto copy = [&] { return std::make_shared<collision::WorldSnapshot>(*world.Snapshot()); };
  std::vector<SnapshotPtr> at = {copy()};
  for (int i = 1; i <= 8; ++i) {
    if (i % 3 == 0) {
      Write({Remove("o1"), Put(absl::StrCat("x", i))});
    } else {
      Write({Put(absl::StrCat("o", i % 2), i)});
    }
    at.push_back(copy());
  }
  const Revision oldest = world.oldest_watch();
  EXPECT_LT(oldest, world.oldest_exact()) << "some have no snapshot any more, only events";
  for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
    for (Revision from = oldest; from <= Revision{8}; ++from.value) {
      const auto watch = MustWatch({.from_revision = from, .mode = mode});
      EXPECT_EQ(watch->position(), from);
      Replica replica(*at[static_cast<std::size_t>(from.value)]);
      ASSERT_TRUE(replica.ReadAll(*watch).ok());
      EXPECT_EQ(replica.objects(), at.back()->objects());
      EXPECT_EQ(replica.revision(), Revision{8});
    }
  }
}

TEST_F(WatchTest, ResumingOutsideWhatIsKeptSaysSo) {
  for (int i = 1; i <= 20; ++i) Write({Put("a", i)});
  EXPECT_EQ(world.oldest_watch(), Revision{12});
  for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
    const auto past = world.Watch({.from_revision = Revision{11}, .mode = mode}, [] {});
    EXPECT_EQ(past.status().code(), absl::StatusCode::kOutOfRange);
    EXPECT_EQ(DetailsOf(past.status()).reason, "REVISION_COMPACTED");
    EXPECT_EQ(DetailsOf(past.status()).metadata.at("oldest_revision"), "12");
    const auto future = world.Watch({.from_revision = Revision{21}, .mode = mode}, [] {});
    EXPECT_EQ(DetailsOf(future.status()).reason, "REVISION_IN_FUTURE");
    EXPECT_TRUE(world.Watch({.from_revision = Revision{12}, .mode = mode}, [] {}).ok());
  }
}

TEST_F(WatchTest, EventsAreForgottenAfterFiveMinutes) {
  Write({Put("a")});
  clock.Advance(std::chrono::minutes(5) + std::chrono::seconds(1));
  EXPECT_EQ(world.oldest_watch(), Revision{1});
  EXPECT_EQ(DetailsOf(world.Watch({.from_revision = Revision{0}}, [] {}).status()).reason,
            "REVISION_COMPACTED");
  EXPECT_TRUE(world.Watch({.from_revision = Revision{1}}, [] {}).ok());
}

TEST_F(WatchTest, ASlowLosslessReaderIsEnded) {
  const auto watch = MustWatch();
  MustStep(*watch);
  for (int i = 1; i <= 9; ++i) Write({Put("a", i)});
  const auto step = watch->Next();
  EXPECT_EQ(step.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DetailsOf(step.status()).reason, "WATCH_TOO_SLOW");
  EXPECT_EQ(DetailsOf(step.status()).metadata.at("position"), "0");
  EXPECT_FALSE(watch->Next().ok()) << "it does not go on with a gap";
}

TEST_F(WatchTest, ASlowCoalescedReaderIsNot) {
  const auto watch = MustWatch({.mode = WatchMode::kCoalesced});
  MustStep(*watch);
  for (int i = 1; i <= 100; ++i) Write({Put("a", i)});
  const WatchStep step = MustStep(*watch);
  EXPECT_EQ(step.revision, Revision{100});
  EXPECT_EQ(step.deltas.at(0).after->X_WO.translation().x(), 100);
}

TEST_F(WatchTest, DeletionComesAfterAllEvents) {
  for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
    World other("w", "uid", {});
    auto watch = *other.Watch({.mode = mode}, [] {});
    MustStep(*watch);
    ASSERT_TRUE(other.Apply(std::vector{Put("a")}, {}).ok());
    EXPECT_TRUE(other.Close().ok());
    EXPECT_EQ(MustStep(*watch).revision, Revision{1});
    for (int i = 0; i < 2; ++i) {
      const auto end = watch->Next();
      EXPECT_EQ(end.status().code(), absl::StatusCode::kNotFound);
      EXPECT_EQ(DetailsOf(end.status()).reason, "WORLD_DELETED");
    }
  }
}

TEST_F(WatchTest, DrainingEndsWithABookmarkAfterAllEvents) {
  for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
    World other("w", "uid", {});
    auto watch = *other.Watch({.mode = mode}, [] {});
    MustStep(*watch);
    ASSERT_TRUE(other.Apply(std::vector{Put("a")}, {}).ok());
    other.Drain();
    EXPECT_EQ(MustStep(*watch).kind, Kind::kEvents);
    const WatchStep end = MustStep(*watch);
    EXPECT_EQ(end.kind, Kind::kBookmark);
    EXPECT_EQ(end.revision, Revision{1});
    EXPECT_TRUE(end.last);
    ExpectNothing(*watch);
  }
}

TEST_F(WatchTest, WakesOncePerRevisionAndAtTheEnd) {
  const auto watch = MustWatch();
  Write({Put("a")});
  Write({Put("a")});  // no effect
  EXPECT_EQ(wakes, 1);
  Write({Remove("a")});
  EXPECT_EQ(wakes, 2);
  EXPECT_TRUE(world.Close().ok());
  EXPECT_EQ(wakes, 3);
}

TEST_F(WatchTest, AnEndedWatchIsNotWoken) {
  MustWatch().reset();
  Write({Put("a")});
  EXPECT_EQ(wakes, 0);
}

// A reader may do all its work in `wake`, since no lock of the world is held.
TEST_F(WatchTest, WakeMayReadWriteAndWatch) {
  std::unique_ptr<WatchCursor> watch;
  std::vector<Revision> read;
  const auto on_wake = [&] {
    while (true) {
      const auto step = watch->Next();
      ASSERT_TRUE(step.ok());
      if (!step->has_value()) break;
      read.push_back((*step)->revision);
      if ((*step)->revision < Revision{3}) Write({Put("from_wake", (*step)->revision.value)});
    }
    ASSERT_TRUE(world.Watch({}, [] {}).ok());
  };
  watch = *world.Watch({.from_revision = Revision{0}}, on_wake);
  Write({Put("a")});
  EXPECT_EQ(read, (std::vector<Revision>{{1}, {2}, {3}}));
}

TEST_F(WatchTest, ACursorOutlivesItsWorld) {
  std::unique_ptr<WatchCursor> watch;
  {
    World brief("w", "uid", {});
    watch = *brief.Watch({}, [] {});
    EXPECT_TRUE(brief.Close().ok());
  }
  EXPECT_EQ(MustStep(*watch).kind, Kind::kInitialState);
  EXPECT_EQ(DetailsOf(watch->Next().status()).reason, "WORLD_DELETED");
}

}  // namespace
}  // namespace cwm::server
