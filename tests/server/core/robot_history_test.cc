// Robots in a world's history, watches, names and errors.
#include <gtest/gtest.h>

#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/history.h"
#include "server/core/world.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/core/fake_clock.h"
#include "tests/server/core/replica.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::RemoveRobot;
using collision::Revision;
using collision::testing::Arm;
using collision::testing::ArmUrdf;
using collision::testing::MakeChange;
using collision::testing::PutArm;
using collision::testing::SetElbow;

class RobotHistory : public ::testing::Test {
 protected:
  void Write(const std::vector<Change>& changes) {
    const auto outcome = world.Apply(changes, {});
    ASSERT_TRUE(outcome.ok()) << outcome.status();
  }
  // Six revisions: a robot is put with an object, moved, made anew, joined by another one, replaced
  // and removed.
  void WriteAll() {
    Write({MakeChange(PutArm("arm")), Put("a")});
    Write({MakeChange(SetElbow("arm", 0.5))});
    Write({MakeChange(PutArm("arm", Arm(ArmUrdf("arm", "0.2")))), Move("a", 1)});
    Write({MakeChange(PutArm("bench"))});
    Write({MakeChange(RemoveRobot{"arm"}), MakeChange(PutArm("arm"))});
    Write({MakeChange(RemoveRobot{"bench"}), Remove("a")});
  }
  absl::Status Refusal(const std::vector<Change>& changes) {
    return world.Apply(changes, {}).status();
  }

  FakeClock clock;
  World world{"w", "uid", {.exact_snapshots = 2, .recent_snapshots = 0}, clock.now()};
};

TEST_F(RobotHistory, UndoingEventsLeadsBackToEachSnapshot) {
  History history({}, std::make_shared<const collision::WorldSnapshot>());
  SnapshotPtr latest = history.SnapshotAt({0});
  for (const auto& changes :
       std::vector<std::vector<Change>>{{MakeChange(PutArm("arm")), Put("a")},
                                        {MakeChange(SetElbow("arm", 0.5))},
                                        {MakeChange(RemoveRobot{"arm"}), MakeChange(PutArm("arm"))},
                                        {MakeChange(PutArm("bench")), Remove("a")},
                                        {MakeChange(RemoveRobot{"arm"})}}) {
    SnapshotPtr next = *collision::Apply(latest, changes);
    const auto deltas = collision::Difference(*latest, *next);
    history.Append(
        next, std::make_shared<const Event>(Event{next->revision(),
                                                  {},
                                                  {deltas.begin(), deltas.end()},
                                                  collision::RobotDifference(*latest, *next)}));
    latest = std::move(next);
  }
  for (int r = 0; r <= 5; ++r) {
    const SnapshotPtr undone = UndoEvents(*latest, history.EventsAfter({r}), {r});
    EXPECT_EQ(undone->robots(), history.SnapshotAt({r})->robots()) << "at revision " << r;
    EXPECT_EQ(undone->objects(), history.SnapshotAt({r})->objects()) << "at revision " << r;
  }
}

TEST_F(RobotHistory, WatchesOfBothModesTellRobotsFromEveryRevision) {
  std::vector<SnapshotPtr> starts = {world.Snapshot()};
  const auto first = world.Watch({}, [] {});
  WriteAll();
  ASSERT_EQ(world.Snapshot()->revision(), Revision{6});
  Replica from_the_start(*starts[0]);
  EXPECT_TRUE(from_the_start.ReadAll(**first).ok());
  EXPECT_EQ(from_the_start.robots(), world.Snapshot()->robots());
  for (int r = 0; r <= 6; ++r) {
    for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
      // The client's copy at that revision, from a watch of the whole history.
      const auto whole = world.Watch({.from_revision = Revision{0}}, [] {});
      Replica replica(*starts[0]);
      for (int i = 0; i < r; ++i) replica.Take(**(*whole)->Next());
      const auto watch = world.Watch({.from_revision = Revision{r}, .mode = mode}, [] {});
      ASSERT_TRUE(watch.ok()) << watch.status();
      if (mode == WatchMode::kLossless) {
        EXPECT_TRUE(replica.ReadAll(**watch).ok());
      }
      if (mode == WatchMode::kCoalesced && r < 6) replica.Take(**(*watch)->Next());
      EXPECT_EQ(replica.robots(), world.Snapshot()->robots()) << "resumed at " << r;
      EXPECT_EQ(replica.objects().size(), world.Snapshot()->objects().size());
    }
  }
}

TEST_F(RobotHistory, ARevisionOfARobotAloneIsAnEventAndNoBookmark) {
  Write({MakeChange(PutArm("arm"))});
  for (const WatchMode mode : {WatchMode::kLossless, WatchMode::kCoalesced}) {
    const auto watch = world.Watch({.mode = mode}, [] {});
    EXPECT_EQ((**(*watch)->Next()).snapshot->robots().size(), 1u);
    const double elbow = mode == WatchMode::kLossless ? 0.1 : 0.2;
    Write({MakeChange(SetElbow("arm", elbow))});
    const WatchStep step = **(*watch)->Next();
    EXPECT_EQ(step.kind, WatchStep::Kind::kEvents);
    ASSERT_EQ(step.robot_deltas.size(), 1u);
    EXPECT_EQ(step.robot_deltas[0].after->state[0], elbow);
  }
}

TEST_F(RobotHistory, CountsWhatItAloneHolds) {
  const auto delta = [](collision::WorldRobotPtr before, collision::WorldRobotPtr after) {
    const collision::RobotDelta one{std::move(before), std::move(after)};
    return ApproximateSupersededBytes(std::span(&one, 1));
  };
  Write({MakeChange(PutArm("arm"))});
  const auto first = world.Snapshot()->FindRobot("arm");
  Write({MakeChange(SetElbow("arm", 0.5))});
  const auto moved = world.Snapshot()->FindRobot("arm");
  EXPECT_EQ(delta(nullptr, first), 0);
  EXPECT_GT(delta(first, moved), 0);
  // The memory shared with a moved robot: four shapes for three engines, and the model.
  EXPECT_GT(delta(first, nullptr), delta(first, moved) + 4'000);
}

TEST_F(RobotHistory, EventsOfRobotsCountAmongThoseThatAreKept) {
  World busy{"w", "uid", {.watch_events = 3}, clock.now()};
  ASSERT_TRUE(busy.Apply(std::vector{MakeChange(PutArm("arm"))}, {}).ok());
  for (int i = 1; i <= 5; ++i) {
    ASSERT_TRUE(busy.Apply(std::vector{MakeChange(SetElbow("arm", 0.1 * i))}, {}).ok());
  }
  EXPECT_EQ(busy.oldest_watch(), Revision{3});
}

TEST_F(RobotHistory, NextNamesAreThoseOfNoRobot) {
  Write({MakeChange(PutArm("object_1"))});
  EXPECT_EQ(world.ReserveName("object"), "object_2");
}

TEST_F(RobotHistory, RefusalsSayThatTheyAreAboutARobot) {
  const ErrorDetails unknown = DetailsOf(Refusal({MakeChange(SetElbow("ghost", 0))}));
  EXPECT_EQ(unknown.reason, "ROBOT_UNKNOWN");
  EXPECT_EQ(unknown.metadata.at("robot"), "ghost");
  EXPECT_EQ(unknown.metadata.at("change_index"), "0");
  Write({MakeChange(PutArm("arm"))});
  Change late = MakeChange(SetElbow("arm", 0.5));
  late.expected_object_revision = Revision{7};
  const ErrorDetails mismatch = DetailsOf(Refusal({late}));
  EXPECT_EQ(mismatch.reason, "OBJECT_REVISION_MISMATCH");
  EXPECT_EQ(mismatch.metadata.at("actual_revision"), "1");
  const ErrorDetails joint = DetailsOf(Refusal({Put("a"), MakeChange(SetElbow("arm", 1e7))}));
  ASSERT_EQ(joint.fields.size(), 1u);
  EXPECT_EQ(joint.fields[0].field, "changes[1].robot_state.joints.values[0].value");
}

}  // namespace
}  // namespace cwm::server
