#include "server/core/world.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>

#include "absl/strings/numbers.h"
#include "server/core/error.h"
#include "tests/server/core/fake_clock.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;

constexpr Clock::time_point kNoDeadline = Clock::time_point::max();

class WorldTest : public ::testing::Test {
 protected:
  WriteOutcome MustApply(std::vector<Change> changes, const WriteOptions& options = {}) {
    const auto outcome = world.Apply(changes, options);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *outcome : WriteOutcome{};
  }
  absl::Status Refused(std::vector<Change> changes, const WriteOptions& options = {}) {
    const SnapshotPtr before = world.Snapshot();
    const absl::Status status = world.Apply(changes, options).status();
    EXPECT_FALSE(status.ok());
    EXPECT_EQ(world.Snapshot(), before) << "a refused write leaves the world as it was";
    return status;
  }
  absl::StatusOr<SnapshotPtr> At(const RevisionRule& rule) {
    return world.At(rule, kNoDeadline, {});
  }

  FakeClock clock;
  World world{"w", "uid", {.exact_snapshots = 3, .recent_snapshots = 0}, clock.now()};
};

TEST_F(WorldTest, RevisionsCountFromZeroOnePerEffectiveWrite) {
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
  const WriteOutcome first = MustApply({Put("a"), Put("b")});
  EXPECT_EQ(first.revision, Revision{1});
  EXPECT_EQ(first.snapshot, world.Snapshot());
  EXPECT_EQ(NamesIn(*world.Snapshot()), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(MustApply({Move("a", 1)}).revision, Revision{2});
}

TEST_F(WorldTest, ChangesWithoutEffectMakeNoRevision) {
  MustApply({Put("a", 1)});
  const SnapshotPtr before = world.Snapshot();
  EXPECT_EQ(MustApply({Put("a", 1)}).revision, Revision{1});
  EXPECT_EQ(MustApply({Move("a", 1)}).revision, Revision{1});
  EXPECT_EQ(MustApply({Put("b"), Remove("b")}).revision, Revision{1});
  EXPECT_EQ(MustApply({}).revision, Revision{1});
  EXPECT_EQ(world.Snapshot(), before);
}

TEST_F(WorldTest, AMissingObjectRefusesTheWholeListByIndex) {
  const absl::Status status = Refused({Put("a"), Move("ghost", 1)});
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(details.reason, "OBJECT_UNKNOWN");
  EXPECT_EQ(details.metadata.at("object"), "ghost");
  EXPECT_EQ(details.metadata.at("change_index"), "1");
}

TEST_F(WorldTest, AnObjectRevisionThatDoesNotMatchAbortsWithBothRevisions) {
  MustApply({Put("a")});
  MustApply({Move("a", 1)});
  Change stale = Move("a", 2);
  stale.expected_object_revision = Revision{1};
  const absl::Status status = Refused({Put("b"), stale});
  EXPECT_EQ(status.code(), absl::StatusCode::kAborted);
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(details.reason, "OBJECT_REVISION_MISMATCH");
  EXPECT_EQ(details.metadata.at("object"), "a");
  EXPECT_EQ(details.metadata.at("expected_revision"), "1");
  EXPECT_EQ(details.metadata.at("actual_revision"), "2");
  stale.expected_object_revision = Revision{2};
  EXPECT_EQ(MustApply({Put("b"), stale}).revision, Revision{3});
}

TEST_F(WorldTest, ABadChangeNamesItsPlaceInTheListAndItsField) {
  Change bad = Put("b");
  std::get<collision::PutObject>(bad.what).margin_m = -1;
  const absl::Status status = Refused({Put("a"), bad});
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(details.reason, "INVALID_FIELD");
  ASSERT_EQ(details.fields.size(), 1u);
  EXPECT_EQ(details.fields[0].field, "changes[1].margin_m");
}

TEST_F(WorldTest, AnExpectedRevisionThatDoesNotMatchAborts) {
  MustApply({Put("a")});
  const absl::Status status = Refused({Put("b")}, {.expected_revision = Revision{0}});
  EXPECT_EQ(status.code(), absl::StatusCode::kAborted);
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(details.reason, "REVISION_MISMATCH");
  EXPECT_EQ(details.metadata.at("expected_revision"), "0");
  EXPECT_EQ(details.metadata.at("actual_revision"), "1");
  EXPECT_EQ(MustApply({Put("b")}, {.expected_revision = Revision{1}}).revision, Revision{2});
}

TEST_F(WorldTest, ARetryGetsTheFirstReplyAndChangesNothing) {
  const WriteOptions options{.request_id = "r1", .request_digest = "put a"};
  EXPECT_FALSE(MustApply({Put("a")}, options).replayed);
  MustApply({Remove("a")});
  const WriteOutcome retry = MustApply({Put("a")}, options);
  EXPECT_TRUE(retry.replayed);
  EXPECT_EQ(retry.revision, Revision{1});
  EXPECT_EQ(world.Snapshot()->revision(), Revision{2});
}

// The expected revision was right for the first try; the retry must not fail because of it.
TEST_F(WorldTest, ARetryIsReplayedThoughItsExpectedRevisionIsPast) {
  const WriteOptions options{
      .expected_revision = Revision{0}, .request_id = "r1", .request_digest = "d"};
  MustApply({Put("a")}, options);
  EXPECT_TRUE(MustApply({Put("a")}, options).replayed);
}

TEST_F(WorldTest, OtherContentUnderARequestIdIsRefused) {
  MustApply({Put("a")}, {.request_id = "r1", .request_digest = "put a"});
  const absl::Status status = Refused({Put("b")}, {.request_id = "r1", .request_digest = "put b"});
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(DetailsOf(status).reason, "REQUEST_ID_REUSED");
}

TEST_F(WorldTest, AFailedFirstTryIsNotRemembered) {
  const WriteOptions options{.request_id = "r1", .request_digest = "d"};
  EXPECT_EQ(Refused({Move("a", 1)}, options).code(), absl::StatusCode::kNotFound);
  MustApply({Put("a")});
  const WriteOutcome second = MustApply({Move("a", 1)}, options);
  EXPECT_FALSE(second.replayed);
  EXPECT_EQ(second.revision, Revision{2});
}

TEST_F(WorldTest, RequestIdsAreForgottenAfterTenMinutes) {
  const WriteOptions options{.request_id = "r1", .request_digest = "d"};
  MustApply({Put("a")}, options);
  clock.Advance(std::chrono::minutes(10));
  EXPECT_TRUE(MustApply({Put("a")}, options).replayed);
  clock.Advance(std::chrono::seconds(1));
  EXPECT_FALSE(MustApply({Put("a")}, options).replayed);
}

TEST_F(WorldTest, RequestIdsThatCannotBeRememberedAreRefused) {
  World small("w", "uid", {.request_ids = 2}, clock.now());
  for (const char* id : {"r1", "r2"}) {
    ASSERT_TRUE(small.Apply({}, {.request_id = id}).ok());
  }
  const absl::Status status = small.Apply({}, {.request_id = "r3"}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DetailsOf(status).reason, "REQUEST_IDS_EXHAUSTED");
  EXPECT_TRUE(DetailsOf(status).retry_after_s.has_value());
  EXPECT_TRUE(small.Apply({}, {.request_id = "r1"})->replayed);
  EXPECT_TRUE(small.Apply({}, {}).ok());
  clock.Advance(std::chrono::minutes(11));
  EXPECT_TRUE(small.Apply({}, {.request_id = "r3"}).ok());
}

TEST_F(WorldTest, TooLongARequestIdIsABadField) {
  const absl::Status status = Refused({Put("a")}, {.request_id = std::string(129, 'x')});
  EXPECT_EQ(DetailsOf(status).reason, "INVALID_FIELD");
  EXPECT_EQ(DetailsOf(status).fields.at(0).field, "request_id");
}

TEST_F(WorldTest, PrecheckTellsWhatTheWriteWouldGet) {
  MustApply({Put("a")}, {.request_id = "r1", .request_digest = "d"});
  EXPECT_FALSE(world.Precheck({})->has_value());
  EXPECT_TRUE((*world.Precheck({.request_id = "r1", .request_digest = "d"}))->replayed);
  EXPECT_EQ(DetailsOf(world.Precheck({.expected_revision = Revision{7}}).status()).reason,
            "REVISION_MISMATCH");
}

TEST_F(WorldTest, AnswersAtExactlyTheKeptRevisions) {
  for (int i = 1; i <= 5; ++i) MustApply({Put("a", i)});
  EXPECT_EQ(world.oldest_exact(), Revision{3});
  for (int i = 3; i <= 5; ++i) {
    const auto snapshot = At(Exactly{{i}});
    ASSERT_TRUE(snapshot.ok());
    EXPECT_EQ((*snapshot)->revision(), Revision{i});
    EXPECT_EQ((*snapshot)->Find("a")->X_WO.translation().x(), i);
  }
  const absl::Status past = At(Exactly{{2}}).status();
  EXPECT_EQ(past.code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(DetailsOf(past).reason, "REVISION_COMPACTED");
  EXPECT_EQ(DetailsOf(past).metadata.at("oldest_revision"), "3");
  EXPECT_EQ(DetailsOf(past).metadata.at("nearest_revision"), "3");
  EXPECT_EQ(DetailsOf(past).metadata.at("latest_revision"), "5");
  EXPECT_EQ(DetailsOf(At(Exactly{{-1}}).status()).reason, "REVISION_COMPACTED");
  const absl::Status future = At(Exactly{{6}}).status();
  EXPECT_EQ(future.code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(DetailsOf(future).reason, "REVISION_IN_FUTURE");
  EXPECT_EQ((*At(Latest{}))->revision(), Revision{5});
}

TEST_F(WorldTest, ARevisionStaysExactForWhoeverUsesItWhileAWorldMakesThirtyASecond) {
  World live{"live", "uid2", {}, clock.now()};
  const auto move = [&](int i) { ASSERT_TRUE(live.Apply(std::vector{Put("a", i)}, {}).ok()); };
  move(1);
  int last_asked = 1, i = 1;
  for (; i <= 30 * 200; ++i) {
    clock.Advance(std::chrono::microseconds(33'333));
    move(i + 1);
    if (i - last_asked < 30 * 50 && i != 20) continue;
    last_asked = i;
    const auto used = live.At(Exactly{{1}}, kNoDeadline, {});
    ASSERT_TRUE(used.ok()) << "after " << i / 30 << " s: " << used.status();
    EXPECT_EQ((*used)->Find("a")->X_WO.translation().x(), 1);
  }
  EXPECT_GT(live.oldest_exact().value, i - 30 * 160) << "a lease is for its user alone";
  // Half a minute ago one revision a second is kept.
  int kept_count = 0;
  for (int revision = i - 1'000; revision < i - 1'000 + 30; ++revision) {
    const auto exact = live.At(Exactly{{revision}}, kNoDeadline, {});
    if (exact.ok()) {
      ++kept_count;
      continue;
    }
    const ErrorDetails details = DetailsOf(exact.status());
    EXPECT_EQ(details.reason, "REVISION_COMPACTED");
    int nearest = 0;
    ASSERT_TRUE(absl::SimpleAtoi(details.metadata.at("nearest_revision"), &nearest));
    EXPECT_LE(std::abs(nearest - revision), 31);
    EXPECT_TRUE(live.At(Exactly{{nearest}}, kNoDeadline, {}).ok());
  }
  EXPECT_LE(kept_count, 2);
  EXPECT_EQ((*live.At(AtLeast{{i - 1'000}}, kNoDeadline, {}))->revision(), Revision{i});
}

TEST_F(WorldTest, AtLeastWaitsForTheRevision) {
  MustApply({Put("a")});
  EXPECT_EQ((*At(AtLeast{{1}}))->revision(), Revision{1});
  std::thread writer([&] {
    MustApply({Put("b")});
    MustApply({Put("c")});
  });
  const auto snapshot = At(AtLeast{{3}});
  writer.join();
  ASSERT_TRUE(snapshot.ok());
  EXPECT_GE((*snapshot)->revision(), Revision{3});
}

TEST_F(WorldTest, AtLeastEndsAtDeadlineStopAndDeletion) {
  const auto late = world.At(AtLeast{{1}}, Clock::now(), {});
  EXPECT_EQ(late.status().code(), absl::StatusCode::kDeadlineExceeded);

  std::stop_source stop;
  std::thread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(world.At(AtLeast{{1}}, kNoDeadline, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
  stopper.join();

  std::thread closer([&] { EXPECT_TRUE(world.Close().ok()); });
  EXPECT_EQ(DetailsOf(At(AtLeast{{1}}).status()).reason, "WORLD_DELETED");
  closer.join();
}

TEST_F(WorldTest, ADeletedWorldRefusesWritesAndWatches) {
  MustApply({Put("a")});
  const SnapshotPtr held = world.Snapshot();
  EXPECT_TRUE(world.Close().ok());
  EXPECT_EQ(DetailsOf(Refused({Put("b")})).reason, "WORLD_DELETED");
  EXPECT_EQ(DetailsOf(world.Watch({}, [] {}).status()).reason, "WORLD_DELETED");
  EXPECT_EQ(NamesIn(*held), std::vector<std::string>{"a"});
}

TEST_F(WorldTest, UpdateShowsTheLatestSnapshotAndAppliesWhatIsMade) {
  MustApply({Put("a")});
  const auto outcome = world.Update(
      [&](const SnapshotPtr& latest) {
        EXPECT_EQ(latest, world.Snapshot());
        return std::vector<Change>{Put(world.ReserveName("object"))};
      },
      {});
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome->revision, Revision{2});
  EXPECT_NE(world.Snapshot()->Find("object_1"), nullptr);
}

TEST_F(WorldTest, UpdatePassesARefusalOn) {
  const auto outcome = world.Update(
      [](const SnapshotPtr&) -> absl::StatusOr<std::vector<Change>> {
        return absl::CancelledError("no");
      },
      {});
  EXPECT_EQ(outcome.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(world.Snapshot()->revision(), Revision{0});
}

TEST_F(WorldTest, NamesAreNeverGivenTwice) {
  MustApply({Put("object_2")});  // a user took the name first
  EXPECT_EQ(world.ReserveName("object"), "object_1");
  EXPECT_EQ(world.ReserveName("object"), "object_3");
  EXPECT_EQ(world.ReserveName("support"), "support_1");
  MustApply({Put("object_4"), Put("object_5")});
  MustApply({Remove("object_5")});
  EXPECT_EQ(world.ReserveName("object"), "object_5");
  EXPECT_EQ(world.ReserveName("object"), "object_6");
}

TEST_F(WorldTest, ObservationsMakeNoRevisionAndGoWithTheObject) {
  using std::chrono::system_clock;
  const system_clock::time_point noon{std::chrono::hours(12)};
  MustApply({Put("a"), Put("b")});
  const std::vector<Sighting> seen = {{.name = "a"}, {.name = "ghost"}};
  Observations& observations = world.observations();
  observations.Record(seen, noon, *world.Snapshot());
  observations.Record(seen, noon - std::chrono::hours(1), *world.Snapshot());  // arrived late
  EXPECT_EQ(world.Snapshot()->revision(), Revision{1});
  EXPECT_EQ(observations.Get("a").last, noon);
  EXPECT_EQ(observations.Get("b").last, std::nullopt);
  EXPECT_EQ(observations.Get("ghost").last, std::nullopt);
  MustApply({Remove("a")});
  MustApply({Put("a")});
  EXPECT_EQ(observations.Get("a").last, std::nullopt) << "another object of the same name";
}

TEST_F(WorldTest, ObservationsAreToldInTheirOrderTheLastOfEachObject) {
  using std::chrono::system_clock;
  const system_clock::time_point noon{std::chrono::hours(12)};
  MustApply({Put("a"), Put("b"), Put("c")});
  Observations& observations = world.observations();
  const auto see = [&](const std::string& name, int second) {
    const std::vector<Sighting> seen = {{.name = name}};
    observations.Record(seen, noon + std::chrono::seconds(second), *world.Snapshot());
  };
  see("a", 0);
  see("b", 1);
  const std::uint64_t first_two = observations.last_number();
  see("c", 2);
  see("a", 3);
  const auto all = observations.NewerThan(0, 10);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].name, "b");
  EXPECT_EQ(all[2].name, "a");
  EXPECT_EQ(all[2].last, noon + std::chrono::seconds(3));
  const auto later = observations.NewerThan(first_two, 1);
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].name, "c");
  EXPECT_EQ(observations.NewerThan(later[0].number, 10).at(0).name, "a");
  EXPECT_TRUE(observations.NewerThan(observations.last_number(), 10).empty());
}

TEST_F(WorldTest, KeepsOnePosePerSensor) {
  EXPECT_FALSE(world.SensorPoseOf("head").has_value());
  EXPECT_TRUE(world.SetSensorPose("head", {MakeTranslation(1, 0, 0), true}).ok());
  EXPECT_TRUE(world.SetSensorPose("hand", {MakeTranslation(2, 0, 0), false}).ok());
  EXPECT_TRUE(world.SetSensorPose("head", {MakeTranslation(3, 0, 0), true}).ok());
  EXPECT_EQ(world.SensorPoseOf("head")->X_WC.translation().x(), 3);
  EXPECT_EQ(world.SensorPoseOf("hand")->X_WC.translation().x(), 2);
  EXPECT_FALSE(world.SensorPoseOf("hand")->given);
}

}  // namespace
}  // namespace cwm::server
