#include "server/core/live/robot_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "server/core/error.h"
#include "server/core/world.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::server {
namespace {

using collision::testing::Arm;
using collision::testing::JointText;
using collision::testing::Links;
using collision::testing::MakeChange;
using collision::testing::PutArm;
using collision::testing::Robot;
using perception::Stamp;
using perception::StateSource;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Stamp kFirstStamp{std::chrono::hours(400'000)};

// Indices of the variables of test_arm.h.
constexpr int kElbow = 0, kSlide = 1, kGrip = 2, kFloat = 3;

collision::WorldRobotPtr PlacedArm(std::int64_t create_revision = 1,
                                   std::shared_ptr<const collision::RobotGeometry> robot = Arm()) {
  collision::WorldRobot placed;
  placed.name = "arm";
  placed.state = collision::DefaultVariables(*robot->model);
  placed.robot = std::move(robot);
  placed.X_WB = MakeTranslation(1, 2, 3);
  placed.create_revision = placed.state_revision = {create_revision};
  return collision::Place(std::move(placed));
}

class RobotStatesTest : public ::testing::Test {
 protected:
  RobotStates::Added Add(std::vector<int> variables, std::vector<StampedRobotState> told) {
    Stamp now = told.front().stamp;
    for (const StampedRobotState& each : told) now = std::max(now, each.stamp);
    const auto added = states.Add(*arm, variables, told, now);
    EXPECT_TRUE(added.ok()) << added.status();
    return added.value_or(RobotStates::Added{});
  }
  // Tells the elbow, milliseconds after the beginning.
  RobotStates::Added TellElbow(int at_ms, double value) {
    return Add({kElbow}, {{.stamp = kFirstStamp + milliseconds(at_ms), .values = {value}}});
  }
  RobotStateAt StateAt(double at_ms) const {
    return states.StateAt(*arm, kFirstStamp + std::chrono::microseconds(std::llround(at_ms * 1e3)));
  }
  double ElbowAt(double at_ms) const {
    const RobotStateAt at = StateAt(at_ms);
    return at.values.empty() ? NAN : at.values[kElbow];
  }

  collision::WorldRobotPtr arm = PlacedArm();
  RobotStates states;
};

TEST_F(RobotStatesTest, InterpolateBetweenTheStatesAroundTheStamp) {
  TellElbow(0, 0.1);
  TellElbow(10, 0.3);
  TellElbow(30, 0.2);
  const RobotStateAt at = StateAt(5);
  EXPECT_EQ(at.source, StateSource::kInterpolated);
  EXPECT_NEAR(at.values[kElbow], 0.2, 1e-12);
  EXPECT_NEAR(at.speeds_per_s[kElbow], 20, 1e-9);
  EXPECT_EQ(at.late, std::chrono::nanoseconds(0));
  EXPECT_NEAR(ElbowAt(25), 0.225, 1e-12);
  for (const auto& [at_ms, told] : {std::pair(0, 0.1), {10, 0.3}, {30, 0.2}}) {
    EXPECT_DOUBLE_EQ(ElbowAt(at_ms), told);
    EXPECT_EQ(StateAt(at_ms).source, StateSource::kInterpolated);
  }
  // What nobody tells is as in the world.
  EXPECT_EQ(at.values[kSlide], arm->state[kSlide]);
  EXPECT_EQ(at.X_WB.translation(), Vector3(1, 2, 3));
}

TEST_F(RobotStatesTest, ExtrapolateForTwentyMillisecondsAtMost) {
  TellElbow(0, 0.0);
  TellElbow(10, 0.1);
  const RobotStateAt at = StateAt(30);
  EXPECT_EQ(at.source, StateSource::kExtrapolated);
  EXPECT_NEAR(at.values[kElbow], 0.3, 1e-12);
  EXPECT_EQ(at.late, milliseconds(20));
  const RobotStateAt stale = StateAt(30.1);
  EXPECT_EQ(stale.source, StateSource::kMissing);
  EXPECT_EQ(stale.reason, "ROBOT_STATE_STALE");
  EXPECT_EQ(stale.late, std::chrono::microseconds(20'100));
  EXPECT_TRUE(stale.values.empty());
  const RobotStateAt early = StateAt(-1);
  EXPECT_EQ(early.source, StateSource::kMissing);
  EXPECT_EQ(early.reason, "ROBOT_STATE_MISSING");
}

TEST_F(RobotStatesTest, TheSpeedOfAFastStreamIsThatOverTenMilliseconds) {
  // The last stamp is half a millisecond early.
  for (int i = 0; i < 20; ++i) TellElbow(i, 1e-3 * i);
  Add({kElbow}, {{.stamp = kFirstStamp + std::chrono::microseconds(19'500), .values = {0.02}}});
  EXPECT_NEAR(StateAt(25).speeds_per_s[kElbow], 1, 0.11);
}

TEST_F(RobotStatesTest, ASingleStateIsHeldAndNoneIsMissing) {
  EXPECT_EQ(StateAt(0).reason, "ROBOT_STATE_MISSING");
  EXPECT_FALSE(states.IsTold(*arm, kFirstStamp));
  TellElbow(0, 0.4);
  EXPECT_EQ(StateAt(0).source, StateSource::kInterpolated);
  const RobotStateAt held = StateAt(20);
  EXPECT_EQ(held.source, StateSource::kHeld);
  EXPECT_EQ(held.values[kElbow], 0.4);
  EXPECT_EQ(held.speeds_per_s[kElbow], 0);
  EXPECT_EQ(StateAt(21).reason, "ROBOT_STATE_STALE");
  EXPECT_TRUE(states.IsTold(*arm, kFirstStamp + seconds(10)));
  EXPECT_FALSE(states.IsTold(*arm, kFirstStamp + seconds(11))) << "nobody tells it any more";
  EXPECT_EQ(StateAt(11'000).reason, "ROBOT_STATE_MISSING");
}

TEST_F(RobotStatesTest, AreNotInterpolatedOverAGapUnlessTheRobotRested) {
  TellElbow(0, 0.0);
  TellElbow(201, 0.1);
  TellElbow(900, 0.1);
  EXPECT_EQ(StateAt(100).reason, "ROBOT_STATE_STALE");
  EXPECT_DOUBLE_EQ(ElbowAt(0), 0.0);
  EXPECT_DOUBLE_EQ(ElbowAt(201), 0.1);
  EXPECT_DOUBLE_EQ(ElbowAt(500), 0.1);
}

TEST_F(RobotStatesTest, MayComeInAnyOrderAndTwice) {
  std::vector<int> order;
  for (int i = 0; i < 60; ++i) order.push_back(i);
  const auto value_of = [](int i) { return 0.01 * (i * i % 37); };
  for (unsigned seed = 1; seed <= 20; ++seed) {
    states.Forget("arm");
    std::ranges::shuffle(order, std::mt19937(seed));
    for (const int i : order) {
      EXPECT_EQ(TellElbow(10 * i, value_of(i)).taken, 1);
      const RobotStates::Added again = TellElbow(10 * i, 9);
      EXPECT_EQ(again.taken, 0);
      EXPECT_EQ(again.ignored, 1);
    }
    for (int i = 0; i + 1 < 60; ++i) {
      EXPECT_NEAR(ElbowAt(10 * i), value_of(i), 1e-12);
      EXPECT_NEAR(ElbowAt(10 * i + 2.5), 0.75 * value_of(i) + 0.25 * value_of(i + 1), 1e-12);
    }
  }
}

TEST_F(RobotStatesTest, ReachTwoSecondsOrFiveHundredStatesBack) {
  for (int i = 0; i <= 300; ++i) TellElbow(10 * i, 0.1);
  EXPECT_EQ(StateAt(999).reason, "ROBOT_STATE_MISSING");
  EXPECT_EQ(ElbowAt(1'000), 0.1);
  for (int i = 1; i <= 600; ++i) TellElbow(3'000 + i, 0.2);
  EXPECT_EQ(StateAt(3'600 - 512).reason, "ROBOT_STATE_MISSING");
  EXPECT_EQ(ElbowAt(3'600 - 511), 0.2);
  EXPECT_EQ(TellElbow(3'000, 0.3).ignored, 1) << "older than all that are kept";
}

TEST_F(RobotStatesTest, RefuseStampsOfTheFutureAndOfLongAgoByField) {
  const auto refusal = [&](std::vector<Stamp> stamps) {
    std::vector<StampedRobotState> told;
    for (const Stamp stamp : stamps) told.push_back({.stamp = stamp, .values = {0.5}});
    const std::vector<int> elbow = {kElbow};
    const auto added = states.Add(*arm, elbow, told, kFirstStamp);
    return added.ok() ? std::string() : std::string(added.status().message());
  };
  EXPECT_EQ(refusal({kFirstStamp, kFirstStamp + milliseconds(1'500)}),
            "states.stamps[1]: is 1.500 s after the server's clock, must be at most 1 s after it");
  EXPECT_EQ(StateAt(0).reason, "ROBOT_STATE_MISSING") << "all are taken or none";
  EXPECT_EQ(refusal({kFirstStamp + seconds(1)}), "");
  EXPECT_EQ(refusal({kFirstStamp - seconds(1)}), "");
  EXPECT_EQ(refusal({kFirstStamp - milliseconds(1'001)}),
            "states.stamps[0]: is 2.001 s before the newest state, must be at most 2 s before it");
  const std::vector<int> both = {kElbow, kSlide};
  const std::vector<StampedRobotState> narrow = {{.stamp = kFirstStamp, .values = {0.1, 0.2}},
                                                 {.stamp = kFirstStamp, .values = {0.1}}};
  const absl::Status width = states.Add(*arm, both, narrow, kFirstStamp).status();
  EXPECT_EQ(DetailsOf(width).fields.at(0).field, "states.rows");
  EXPECT_EQ(DetailsOf(width).fields.at(0).description,
            "row 1 has 1 values, must have 2, one for each variable that is told of the robot");
}

TEST_F(RobotStatesTest, AStreamThatWasSilentMayBeginAnew) {
  TellElbow(0, 0.1);
  const std::vector<int> elbow = {kElbow};
  const std::vector<StampedRobotState> yesterday = {
      {.stamp = kFirstStamp - std::chrono::hours(24), .values = {0.7}}};
  EXPECT_FALSE(states.Add(*arm, elbow, yesterday, kFirstStamp + seconds(10)).ok());
  EXPECT_TRUE(states.Add(*arm, elbow, yesterday, kFirstStamp + seconds(11)).ok());
  EXPECT_EQ(states.StateAt(*arm, yesterday[0].stamp).values[kElbow], 0.7);
}

TEST_F(RobotStatesTest, ARobotThatReplacedAnotherHasNone) {
  TellElbow(0, 0.1);
  const collision::WorldRobotPtr other = PlacedArm(7);
  EXPECT_EQ(states.StateAt(*other, kFirstStamp).reason, "ROBOT_STATE_MISSING");
  arm = other;
  TellElbow(0, 0.6);
  EXPECT_EQ(ElbowAt(0), 0.6);
  EXPECT_EQ(states.StateAt(*PlacedArm(), kFirstStamp).reason, "ROBOT_STATE_MISSING");
}

TEST_F(RobotStatesTest, OfTwoStreamsAreCombined) {
  TellElbow(0, 0.0);
  TellElbow(20, 0.2);
  Add({kGrip}, {{.stamp = kFirstStamp + milliseconds(5), .values = {0.01}},
                {.stamp = kFirstStamp + milliseconds(15), .values = {0.03}}});
  const RobotStateAt at = StateAt(10);
  EXPECT_EQ(at.source, StateSource::kInterpolated);
  EXPECT_NEAR(at.values[kElbow], 0.1, 1e-12);
  EXPECT_NEAR(at.values[kGrip], 0.02, 1e-12);
  EXPECT_EQ(StateAt(20).source, StateSource::kExtrapolated) << "of the gripper";
  EXPECT_EQ(StateAt(36).reason, "ROBOT_STATE_STALE");
  // A stream that tells both takes their place.
  Add({kGrip, kElbow}, {{.stamp = kFirstStamp + milliseconds(40), .values = {0.04, 0.5}}});
  EXPECT_EQ(StateAt(10).reason, "ROBOT_STATE_MISSING");
  EXPECT_EQ(ElbowAt(40), 0.5);
}

TEST_F(RobotStatesTest, ContinuousJointsTurnTheShorterWay) {
  arm = PlacedArm(1, Arm(Robot(Links("ab") + JointText("wheel", "continuous", "a", "b", "")),
                         "<robot name=\"r\"/>"));
  constexpr double kPi = std::numbers::pi;
  Add({0}, {{.stamp = kFirstStamp, .values = {kPi - 0.1}},
            {.stamp = kFirstStamp + milliseconds(10), .values = {-kPi + 0.1}}});
  EXPECT_NEAR(std::abs(std::remainder(ElbowAt(5), 2 * kPi)), kPi, 1e-12);
  EXPECT_NEAR(StateAt(5).speeds_per_s[0], 20, 1e-9);
  EXPECT_NEAR(std::remainder(ElbowAt(15) - (-kPi + 0.2), 2 * kPi), 0, 1e-12);
}

TEST_F(RobotStatesTest, FloatingJointsTurnTheShorterWayToo) {
  const std::vector<int> variables = {kFloat,     kFloat + 1, kFloat + 2, kFloat + 3,
                                      kFloat + 4, kFloat + 5, kFloat + 6};
  const auto about_z = [](double angle, double sign) {
    return std::vector<double>{
        0.1, 0, 0, 0, 0, sign * std::sin(angle / 2), sign * std::cos(angle / 2)};
  };
  Add(variables, {{.stamp = kFirstStamp, .values = about_z(0.1, 1)},
                  {.stamp = kFirstStamp + milliseconds(10), .values = about_z(0.3, -1)}});
  const std::vector<perception::LinkAtStamp> links = LinksAt(arm->model(), StateAt(5));
  const int link = *arm->model().FindLink("free");
  const Pose X_BL = arm->X_WB.inverse() * links[static_cast<std::size_t>(link)].X_WL;
  const Eigen::AngleAxisd turn(Matrix3(X_BL.linear()));
  EXPECT_NEAR(turn.angle() * turn.axis().z(), 0.2, 1e-6);
  EXPECT_NEAR(links[static_cast<std::size_t>(link)].V_WL.angular_W_rad_s.z(), 20, 0.1);
}

TEST_F(RobotStatesTest, LinksMoveWithTheirJointsAndTheBase) {
  TellElbow(0, 0.0);
  TellElbow(10, 0.01);
  Add({kSlide}, {{.stamp = kFirstStamp, .values = {0.1}, .X_WB = MakeTranslation(0, 0, 0)},
                 {.stamp = kFirstStamp + milliseconds(10),
                  .values = {0.1},
                  .X_WB = MakeTranslation(0.02, 0, 0)}});
  const RobotStateAt at = StateAt(5);
  EXPECT_NEAR(at.X_WB.translation().x(), 0.01, 1e-12);
  const auto links = LinksAt(arm->model(), at);
  const auto& root = links[0];
  EXPECT_NEAR((root.V_WL.linear_W_m_s - Vector3(2, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(root.V_WL.angular_W_rad_s.norm(), 0, 1e-9);
  const auto tip = static_cast<std::size_t>(*arm->model().FindLink("tip"));
  EXPECT_NEAR(links[tip].V_WL.angular_W_rad_s.norm(), 1, 1e-6);
  // The speed of the tip about the elbow's axis, and that of the base.
  const auto upper = static_cast<std::size_t>(*arm->model().FindLink("upper"));
  const Vector3 lever = links[tip].X_WL.translation() - links[upper].X_WL.translation();
  const Vector3 expected = Vector3(2, 0, 0) + links[tip].V_WL.angular_W_rad_s.cross(lever);
  EXPECT_NEAR((links[tip].V_WL.linear_W_m_s - expected).norm(), 0, 1e-3);
}

TEST_F(RobotStatesTest, TheNewestIsTakenOnceByAFrameOrByAWriteThirtyTimesASecond) {
  const Clock::time_point now{std::chrono::hours(3)};
  EXPECT_FALSE(states.DueAt().has_value());
  EXPECT_FALSE(states.LeaveToFrame(now));
  TellElbow(0, 0.1);
  TellElbow(10, 0.2);
  EXPECT_EQ(states.DueAt(), now + milliseconds(200)) << "left to the next frame";
  EXPECT_FALSE(states.ClaimDue(now + milliseconds(199)));
  EXPECT_TRUE(states.LeaveToFrame(now + milliseconds(30)));
  const auto taken = states.TakeAll();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].name, "arm");
  EXPECT_FALSE(taken[0].X_WB.has_value());
  ASSERT_EQ(taken[0].joints.values.size(), 1u);
  EXPECT_EQ(taken[0].joints.values[0].variable, "elbow");
  EXPECT_EQ(taken[0].joints.values[0].value, 0.2);
  EXPECT_FALSE(states.DueAt().has_value());
  TellElbow(5, 0.3);
  EXPECT_FALSE(states.DueAt().has_value()) << "a late one is not the newest";
  TellElbow(20, 0.4);
  EXPECT_TRUE(states.ClaimDue(now + milliseconds(230)));
  EXPECT_FALSE(states.ClaimDue(now + milliseconds(230))) << "another stream writes";
  EXPECT_EQ(states.TakeAll().size(), 1u);
  TellElbow(30, 0.5);
  EXPECT_EQ(states.DueAt(), now + milliseconds(263));
  EXPECT_FALSE(states.ClaimDue(now + milliseconds(262)));
  EXPECT_TRUE(states.ClaimDue(now + milliseconds(263)));
  EXPECT_EQ(states.TakeAll().size(), 1u);
}

TEST_F(RobotStatesTest, OfARemovedRobotAreForgottenByTheWorld) {
  World world("w", "uid", {});
  ASSERT_TRUE(world.Apply(std::vector{MakeChange(PutArm("arm"))}, {}).ok());
  arm = world.Snapshot()->FindRobot("arm");
  const std::vector<int> elbow = {kElbow};
  const std::vector<StampedRobotState> told = {{.stamp = kFirstStamp, .values = {0.25}}};
  ASSERT_TRUE(world.robot_states().Add(*arm, elbow, told, kFirstStamp).ok());
  EXPECT_EQ(world.robot_states().StateAt(*arm, kFirstStamp).values[kElbow], 0.25);
  ASSERT_TRUE(world.Apply(std::vector{MakeChange(collision::RemoveRobot{"arm"})}, {}).ok());
  EXPECT_EQ(world.robot_states().StateAt(*arm, kFirstStamp).reason, "ROBOT_STATE_MISSING");
  EXPECT_TRUE(world.robot_states().TakeAll().empty());
}

}  // namespace
}  // namespace cwm::server
