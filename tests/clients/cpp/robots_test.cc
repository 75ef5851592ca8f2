// Robots of the C++ client with a real server: the arm of two_link_arm.h, whose poses are worked
// out by hand.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/clients/cpp/running_server.h"
#include "tests/e2e/two_link_arm.h"

namespace cwm::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kTolerance = 1e-9;
constexpr char kSrdf[] = R"(<robot name="arm">
<group name="arm"><joint name="shoulder"/><joint name="elbow"/></group>
<group name="lower"><joint name="elbow"/></group>
<group_state name="bent" group="arm"><joint name="shoulder" value="0.5"/>
<joint name="elbow" value="-1"/></group_state>
<disable_collisions link1="base" link2="upper" reason="Adjacent"/>
<disable_collisions link1="upper" link2="hand" reason="Adjacent"/></robot>)";

class Robots : public ClientTest {
 protected:
  void SetUp() override { world_.LoadRobot({.urdf = kTwoLinkArm, .srdf = kSrdf}); }

  World world_ = Connect();
  const RobotSubject arm_{.robot = "arm", .group = "arm"};
};

TEST_F(Robots, AreLoadedAndDescribed) {
  const Robot robot = world_.GetRobot("arm");
  EXPECT_EQ(world_.Robots().size(), 1U);
  ASSERT_EQ(robot.links.size(), 3U);
  EXPECT_EQ(robot.links[2].parent, "upper");
  EXPECT_EQ(robot.links[2].joint_kind, JointKind::kRevolute);
  EXPECT_EQ(robot.Limits("arm"), (Eigen::MatrixX2d(2, 2) << -3, 3, -3, 3).finished());
  EXPECT_EQ(robot.VariablesOf("lower").size(), 1U);
  EXPECT_EQ(robot.Row(), Eigen::Vector2d(0, 0));
  EXPECT_EQ(robot.Row("arm", "bent"), Eigen::Vector2d(0.5, -1));
  EXPECT_EQ(ErrorOf([&] { robot.group("leg"); }).code(), ErrorCode::kNotFound);
  EXPECT_THAT(ErrorOf([&] { robot.group("leg"); }).what(), HasSubstr("arm, lower"));
  EXPECT_EQ(ErrorOf([&] { robot.Row("arm", "straight"); }).code(), ErrorCode::kNotFound);

  world_.SetRobotState("arm", {.named = NamedState{"arm", "bent"}, .values = {{"elbow", 2}}},
                       At(1, 0, 0));
  const Robot moved = world_.GetRobot("arm");
  EXPECT_EQ(moved.state, Eigen::Vector2d(0.5, 2));
  EXPECT_TRUE(moved.X_WB.isApprox(At(1, 0, 0)));
  world_.DeleteRobot("arm");
  EXPECT_EQ(ErrorOf([&] { world_.GetRobot("arm"); }).reason(), "ROBOT_UNKNOWN");
}

TEST_F(Robots, AreCheckedInStatesOfTheirColumns) {
  // The hand's ball, at (1, 0, 0) with the arm stretched, meets the post; bent back by 3 rad it
  // meets the ball of the base.
  world_.Put("post", Sphere{0.1}, At(1.15, 0, 0));
  const Eigen::Matrix<double, 2, 4> states{{0, 0.5, 0, 4}, {0, 0, 3, 0}};
  const CheckResult answer = world_.Check(arm_, states);
  EXPECT_THAT(answer.verdict, ElementsAre(Verdict::kCollision, Verdict::kFree, Verdict::kCollision,
                                          Verdict::kOutOfLimits));
  EXPECT_EQ(answer.pair(0).object, "post");
  EXPECT_EQ(answer.pair(0).body_link, "hand");
  EXPECT_EQ(answer.object_index[2], kItself);
  EXPECT_EQ(answer.pair(2).object, "arm");
  EXPECT_THAT(std::vector({answer.pair(2).body_link, answer.pair(2).object_link}),
              ::testing::UnorderedElementsAre("base", "hand"));
  EXPECT_EQ(answer.variables[static_cast<std::size_t>(answer.variable_index[3])], "shoulder");
  EXPECT_EQ(answer.variable_index[0], -1);

  EXPECT_FALSE(world_.Check(arm_).all_free()) << "where the robot is";
  EXPECT_TRUE(world_.Check(arm_, std::vector<double>{0.5, 0}).all_free());
  EXPECT_TRUE(world_.Check({RobotSubject{.robot = "arm", .X_WB = At(0, 2, 0)}}).all_free());
  EXPECT_TRUE(world_.Check(RobotSubject{.robot = "arm", .group = "arm", .scope = RobotScope::kSelf})
                  .all_free());
  const RobotSubject lower{
      .robot = "arm", .group = "lower", .base_state = {.values = {{"shoulder", 0.5}}}};
  EXPECT_TRUE(world_.Check(lower, Eigen::VectorXd::Zero(1)).all_free());
  const Error width = ErrorOf([&] { world_.Check(arm_, Eigen::VectorXd::Zero(3)); });
  EXPECT_EQ(width.code(), ErrorCode::kInvalidArgument);
  EXPECT_FALSE(width.fields().empty());
}

TEST_F(Robots, MoveCertifiedBetweenStates) {
  world_.Put("post", Sphere{0.1}, At(0, 1, 0));
  // The hand's ball swings by a quarter of a turn towards the post, and meets it 0.2 m before, in
  // the chord, on a circle of 1 m: at pi/2 - 2 asin(0.1).
  const MotionResult swing =
      world_.Motions(arm_, Eigen::Vector2d(0, 0), Eigen::Vector2d(std::numbers::pi / 2, 0));
  ASSERT_EQ(swing.verdict[0], MotionVerdict::kContact);
  const double at = 1 - 2 * std::asin(0.1) / (std::numbers::pi / 2);
  EXPECT_LE(swing.lo[0], at);
  EXPECT_GE(swing.hi[0], at);
  EXPECT_LT(swing.hi[0] - swing.lo[0], 1e-3);
  Eigen::Matrix<double, 2, 3> path;
  path << 0, -1, 0,  //
      0, 0, 0;
  EXPECT_TRUE(world_.Path(arm_, path).all_free());
}

TEST_F(Robots, CarryWhatIsAttached) {
  world_.Put("cup", Sphere{0.05}, At(1.2, 0, 0));
  world_.Put("post", Sphere{0.1}, At(0, 1.3, 0));
  const Eigen::Vector2d quarter(std::numbers::pi / 2, 0);
  EXPECT_TRUE(world_.Check(arm_, quarter).all_free());
  world_.Attach("cup", "arm", "hand", {"hand"});
  // The cup's centre is now at (0, 1.2, 0): 0.1 m from the post's, whose radii are 0.15 together.
  const CheckResult answer = world_.Check(arm_, quarter);
  ASSERT_EQ(answer.verdict[0], Verdict::kCollision);
  EXPECT_EQ(answer.pair(0).body_object, "cup");
  EXPECT_EQ(answer.pair(0).body_link, "hand");
  const Object cup = world_.Get("cup");
  ASSERT_TRUE(cup.attachment.has_value());
  EXPECT_TRUE(cup.attachment->X_LO.isApprox(At(0.7, 0, 0), kTolerance)) << "hand is at x = 0.5";
  EXPECT_THAT(cup.attachment->touch_links, ElementsAre("hand"));
  world_.Detach("cup");
  EXPECT_FALSE(world_.Get("cup").attachment.has_value());
  const WorldView carrying = world_.WhatIf({Attach{.name = "cup", .robot = "arm", .link = "hand"}});
  EXPECT_FALSE(carrying.Check(arm_, quarter).all_free());
}

TEST_F(Robots, MeasureDistancesLinkByLink) {
  // With the arm stretched its balls are at 0, 0.5 and 1 m; the post is half a metre beside the
  // last one. Neighbours are not checked against each other, so that base and hand are the only
  // pair of the arm itself.
  world_.Put("post", Sphere{0.1}, At(1, 0.5, 0));
  const PairResult answer =
      world_.Distance(arm_, {}, {.max_distance_m = 10, .pairs = DistancePairs::kLinks});
  const std::vector<std::vector<std::string>> pairs = {
      {"base", "arm", "hand"}, {"base", "post", ""}, {"upper", "post", ""}, {"hand", "post", ""}};
  const Eigen::Vector4d expected_m(0.8, std::sqrt(1.25) - 0.2, std::sqrt(0.5) - 0.2, 0.3);
  ASSERT_EQ(answer.size(), 4);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const NamedPairOfParts pair = answer.pair(i);
    EXPECT_EQ(std::vector({pair.body_link, pair.object, pair.object_link}),
              pairs[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(answer.distance_m[i], expected_m[i], kTolerance);
  }

  RobotSubject against_world = arm_;
  against_world.scope = RobotScope::kWorld;
  const PairResult base = world_.Distance(against_world, {}, {.only = {{"arm", "base"}}});
  ASSERT_EQ(base.size(), 1);
  EXPECT_NEAR(base.distance_m[0], expected_m[1], kTolerance);
  world_.Put("nearer", Sphere{0.1}, At(1, -0.3, 0));
  EXPECT_NEAR(world_.Distance(arm_, {}, {.only = {"post"}}).distance_m[0], 0.3, kTolerance);
}

TEST_F(Robots, TellHowDistancesChangeWithTheJoints) {
  // The hand's ball is 1 m from the shoulder and 0.5 m from the elbow, and the post is 0.5 m away
  // in the direction in which both turn it.
  world_.Put("post", Sphere{0.1}, At(1, 0.5, 0));
  const PairResult answer = world_.Distance(arm_, Eigen::Vector2d(0, 0), {.joint_gradient = true});
  ASSERT_EQ(answer.size(), 1);
  EXPECT_NEAR(answer.distance_m[0], 0.3, kTolerance);
  EXPECT_THAT(answer.variables, ElementsAre("shoulder", "elbow"));
  EXPECT_TRUE(answer.joint_gradient.isApprox(Eigen::Vector2d(-1, -0.5), kTolerance))
      << answer.joint_gradient;
  EXPECT_THAT(answer.gradient_kink, ElementsAre(false));
}

TEST_F(Robots, HavePaddingsScalesAndTools) {
  world_.Put("post", Sphere{0.1}, At(1, 0.5, 0));  // 0.3 m from the hand
  RobotSubject padded = arm_;
  padded.link_padding = {{.link = "hand", .padding_m = 0.25}};
  EXPECT_TRUE(world_.Check(padded).all_free());
  padded.link_padding[0].padding_m = 0.35;
  EXPECT_FALSE(world_.Check(padded).all_free());

  const LoadedRobot loaded = world_.LoadRobot(
      {.urdf = kTwoLinkArm, .srdf = kSrdf},
      {.link_padding = {{.link = "*", .padding_m = 0.01}},
       .link_scale = {{.link = "hand", .scale = 2}},
       .tools = {{.name = "tip", .link = "hand", .X_LT = At(0.5, 0, 0), .group = "arm"}}});
  EXPECT_EQ(loaded.robot.links[2].padding_m, 0.01);
  EXPECT_EQ(loaded.robot.links[2].scale, 2);
  ASSERT_EQ(loaded.robot.tools.size(), 1U);
  EXPECT_TRUE(loaded.robot.tools[0].X_LT.isApprox(At(0.5, 0, 0)));
  EXPECT_NEAR(world_.Distance(arm_).distance_m[0], 0.2, kTolerance) << "a ball of 0.2 m";
  EXPECT_EQ(world_.Solve(arm_, At(1, 0, 0), {.tool = "tip"}).status[0], PoseStatus::kSolved);
  EXPECT_EQ(world_.Solve(arm_, At(1.5, 0, 0), {.tool = "tip"}).status[0], PoseStatus::kUnreachable)
      << "the tip of a stretched arm is at 1 m";
}

TEST_F(Robots, CheckPairsOfLinksThatAreNeighbours) {
  const RobotSubject itself{.robot = "arm", .scope = RobotScope::kSelf};
  EXPECT_TRUE(world_.Check(itself, {}, {.margin_m = 0.4}).all_free()) << "neighbours may touch";
  world_.Apply({Allow{.a = {"arm", "base"}, .b = {"arm", "upper"}, .check = true}});
  EXPECT_TRUE(world_.Rules().at(0).check);
  EXPECT_FALSE(world_.Check(itself, {}, {.margin_m = 0.4}).all_free()) << "0.3 m lie between them";
}

TEST_F(Robots, TellThePosesOfTheirLinks) {
  const double half_pi = std::numbers::pi / 2;
  const Eigen::Matrix2d states{{0, half_pi}, {0, -half_pi}};
  const LinkPoses poses = world_.PosesOfLinks(arm_, states);
  ASSERT_TRUE(poses.complete());
  EXPECT_THAT(poses.links, ElementsAre("base", "upper", "hand"));
  EXPECT_TRUE(poses.pose(0, "hand").isApprox(At(0.5, 0, 0), kTolerance));
  // The upper link points along y, and the hand along x again.
  EXPECT_TRUE(poses.pose(1, "hand").isApprox(At(0, 0.5, 0), kTolerance));
  EXPECT_EQ(world_.PosesOfLinks(arm_, states, {"hand"}).X_WL.size(), 2U);
  EXPECT_EQ(ErrorOf([&] { poses.pose(0, "foot"); }).code(), ErrorCode::kNotFound);
}

TEST_F(Robots, SolveForPosesOfTheirTool) {
  // The tool is the hand's tip. Its pose (0.5, 0.5) along y has the one solution (0, pi/2); a pose
  // 2 m away has none.
  Eigen::Isometry3d X_WT = At(0.5, 0.5, 0);
  X_WT.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const std::vector<Eigen::Isometry3d> targets = {X_WT, At(2, 0, 0)};
  const PoseResult answer =
      world_.Solve(arm_, targets, {.tool_link = "hand", .X_LT = At(0.5, 0, 0), .max_solutions = 4});
  ASSERT_TRUE(answer.complete());
  EXPECT_THAT(answer.status, ElementsAre(PoseStatus::kSolved, PoseStatus::kUnreachable));
  EXPECT_EQ(answer.tool_link, "hand");
  ASSERT_EQ(answer.solutions(0).cols(), 1);
  EXPECT_TRUE(answer.solutions(0).col(0).isApprox(Eigen::Vector2d(0, std::numbers::pi / 2), 1e-5))
      << answer.solutions(0);
  EXPECT_EQ(answer.solutions(1).cols(), 0);
  EXPECT_GT(answer.position_error_m[answer.row_begin[1]], 0.9) << "the arm is 1 m long";

  world_.Put("post", Sphere{0.1}, At(0.5, 0.5, 0));
  const SolveOptions free{.tool_link = "hand", .X_LT = At(0.5, 0, 0), .avoid_collision = true};
  EXPECT_EQ(world_.Solve(arm_, X_WT, free).status[0], PoseStatus::kInCollision);
  EXPECT_EQ(world_.WhatIf({Remove{"post"}}).Solve(arm_, X_WT, free).status[0], PoseStatus::kSolved);
}

}  // namespace
}  // namespace cwm::testing
