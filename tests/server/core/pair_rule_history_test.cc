// Pair rules in a world's history, watches and errors.
#include <gtest/gtest.h>

#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/history.h"
#include "server/core/world.h"
#include "tests/server/core/fake_clock.h"
#include "tests/server/core/replica.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::AllowCollision;
using collision::Change;
using collision::ExpireRules;
using collision::Revision;
using collision::SetPairMargin;

const Clock::time_point kNoon{std::chrono::hours(500'000)};

Change Of(decltype(Change::what) what) { return {std::move(what), std::nullopt}; }
Change Allow(const std::string& a, const std::string& b,
             std::optional<Clock::time_point> due = {}) {
  AllowCollision allow{.pair = {{a}, {b}}};
  if (due.has_value()) allow.expires = collision::Expiry{.due = *due, .wall_time = {}};
  return Of(std::move(allow));
}
Change Margin(const std::string& a, const std::string& b, std::optional<double> margin_m) {
  return Of(SetPairMargin{.pair = {{a}, {b}}, .margin_m = margin_m});
}

// The changes of each revision.
std::vector<std::vector<Change>> Story() {
  return {{Put("cup"), Allow("cup", "arm", kNoon)},
          {Margin("cup", "arm", 0.1), Margin("*", "cup", 0.2)},
          {Move("cup", 1)},
          {Of(ExpireRules{kNoon})},
          {Margin("arm", "cup", std::nullopt)},
          {Margin("cup", "*", std::nullopt), Remove("cup")}};
}

TEST(PairRuleHistory, UndoingEventsLeadsBackToEachSnapshot) {
  History history({}, std::make_shared<const collision::WorldSnapshot>());
  SnapshotPtr latest = history.SnapshotAt({0});
  for (const auto& changes : Story()) {
    SnapshotPtr next = *collision::Apply(latest, changes);
    ASSERT_NE(next, latest);
    const auto deltas = collision::Difference(*latest, *next);
    Event event{next->revision(), {}, {deltas.begin(), deltas.end()}, {}, {}};
    event.rule_deltas = collision::RuleDifference(latest->pair_rules(), next->pair_rules());
    history.Append(next, std::make_shared<const Event>(std::move(event)));
    latest = std::move(next);
  }
  for (int r = 0; r <= 6; ++r) {
    const SnapshotPtr undone = UndoEvents(*latest, history.EventsAfter({r}), {r});
    EXPECT_EQ(undone->pair_rules(), history.SnapshotAt({r})->pair_rules()) << "at revision " << r;
  }
}

TEST(PairRuleHistory, WatchesOfBothModesTellRulesFromEveryRevision) {
  const FakeClock clock;
  World world{"w", "uid", {.exact_snapshots = 2, .recent_snapshots = 0}, clock.now()};
  const collision::WorldSnapshot start = *world.Snapshot();
  for (const auto& changes : Story()) ASSERT_TRUE(world.Apply(changes, {}).ok());
  for (int r = 0; r <= 6; ++r) {
    for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
      // The client's copy at that revision, from a watch of the whole history.
      const auto whole = world.Watch({.from_revision = Revision{0}}, [] {});
      Replica replica(start);
      for (int i = 0; i < r; ++i) replica.Take(**(*whole)->Next());
      const auto watch = world.Watch({.from_revision = Revision{r}, .mode = mode}, [] {});
      ASSERT_TRUE(watch.ok()) << watch.status();
      EXPECT_TRUE(replica.ReadAll(**watch).ok());
      EXPECT_EQ(replica.rules(), world.Snapshot()->pair_rules()) << "resumed at " << r;
      EXPECT_EQ(replica.revision(), Revision{6});
    }
  }
}

TEST(PairRuleHistory, ARevisionOfRulesAloneIsAnEventAndCountsAmongThoseThatAreKept) {
  const FakeClock clock;
  World world{"w", "uid", {.watch_events = 3}, clock.now()};
  for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
    const auto watch = world.Watch({.mode = mode}, [] {});
    EXPECT_EQ((*(*watch)->Next())->kind, WatchStep::Kind::kInitialState);
    const double margin_m = mode == WatchMode::kLossless ? 0.1 : 0.2;
    ASSERT_TRUE(world.Apply(std::vector{Margin("a", "b", margin_m)}, {}).ok());
    const WatchStep step = **(*watch)->Next();
    EXPECT_EQ(step.kind, WatchStep::Kind::kEvents);
    ASSERT_EQ(step.rule_deltas.size(), 1u);
    EXPECT_EQ(step.rule_deltas[0].after.margin_m, margin_m);
  }
  for (int i = 3; i <= 5; ++i) {
    ASSERT_TRUE(world.Apply(std::vector{Margin("a", "b", 0.1 * i)}, {}).ok());
  }
  EXPECT_EQ(world.oldest_watch(), Revision{2});
}

TEST(PairRuleHistory, MemoryOfReplacedRulesIsCounted) {
  std::vector<Change> changes;
  for (int i = 0; i < 1'000; ++i) changes.push_back(Margin("a", "b" + std::to_string(i), 0.1));
  const Retention retention{.exact_snapshots = 1'000, .snapshot_bytes = 20 << 20};
  const FakeClock clock;
  World world{"w", "uid", retention, clock.now()};
  ASSERT_TRUE(world.Apply(changes, {}).ok());
  for (int i = 1; i <= 200; ++i) {
    ASSERT_TRUE(world.Apply(std::vector{Margin("a", "b0", i)}, {}).ok());
  }
  // Each revision has a thousand rules of its own, of at most half a kilobyte each.
  const std::int64_t kept = 201 - world.oldest_exact().value;
  EXPECT_GE(kept, 30);
  EXPECT_LE(kept, 120);
}

TEST(PairRuleHistory, RefusalsNameTheFieldOfTheRequest) {
  const FakeClock clock;
  World world{"w", "uid", {}, clock.now()};
  const auto field = [&](const Change& change) {
    const absl::Status status = world.Apply(std::vector{Put("cup"), change}, {}).status();
    const ErrorDetails details = DetailsOf(status);
    EXPECT_EQ(details.reason, "INVALID_FIELD");
    return details.fields.empty() ? "" : details.fields[0].field;
  };
  EXPECT_EQ(field(Allow("cup", "")), "changes[1].allow.pair.b.name");
  EXPECT_EQ(field(Margin("cup", "arm", -1)), "changes[1].margin.margin_m");
  Change expecting = Allow("cup", "arm");
  expecting.expected_object_revision = Revision{1};
  EXPECT_EQ(field(expecting), "changes[1].expected_object_revision");
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
}

}  // namespace
}  // namespace cwm::server
