// Rules that check pairs of links which the SRDF disables, or which are fixed to each other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "collision/motion/body_motion.h"
#include "collision/motion/check_motions.h"
#include "collision/query/robot_body.h"
#include "collision/world/apply_fault.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeChange;

using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

// The arm of ThreeBalls, whose ends a and e may meet by its SRDF, with a ball f of 0.1 m radius
// that is fixed 0.15 m beyond e.
SnapshotPtr WorldWithArm() {
  const auto description = *ReadUrdf(
      testing::Robot(testing::ThreeBalls() + testing::Ball("f") +
                     testing::JointText("tip", "fixed", "e", "f", "<origin xyz=\"0.15 0 0\"/>")),
      testing::NoMeshes);
  const auto semantic = *ReadSrdf(
      "<robot name=\"r\"><disable_collisions link1=\"a\" link2=\"e\"/>"
      "<disable_collisions link1=\"a\" link2=\"f\"/><disable_collisions link1=\"c\" link2=\"f\"/>"
      "</robot>",
      description);
  PutRobot put;
  put.name = "arm";
  put.robot = PrepareRobot(*MakeRobotModel(description, &semantic), std::nullopt);
  put.state = {0, 0};
  return WorldOf({MakeChange(put)});
}

Change Check(const std::string& a, const std::string& b, const std::string& robot = "arm") {
  return MakeChange(AllowCollision{.pair = {{robot, a}, {robot, b}}, .check = true});
}
Change Withdraw(const std::string& a, const std::string& b) {
  return MakeChange(AllowCollision{.pair = {{"arm", a}, {"arm", b}}, .withdraw = true});
}

QueryBody BodyOf(const WorldSnapshot& world) {
  const WorldRobotPtr robot = world.FindRobot("arm");
  return WithCheckedPairs(BodyFromRobot(*robot, RobotScope::kBoth), world.pair_rules(),
                          RobotScope::kBoth);
}

std::vector<Verdict> VerdictsOf(const WorldSnapshot& world, const std::vector<double>& states) {
  const RobotModel& model = world.FindRobot("arm")->model();
  const JointRows rows(model, model.all, {.base = {0, 0}, .rows = states});
  return CheckCollisions(world, BodyOf(world), rows, {})->verdict;
}

TEST(CheckedPairs, OfTheSrdfAreTestedUntilTheyAreWithdrawn) {
  auto world = WorldWithArm();
  const std::vector<double> bent = {0, 3};  // e meets a
  EXPECT_THAT(VerdictsOf(*world, bent), ElementsAre(Verdict::kFree));
  world = *Apply(world, std::vector{Check("e", "a")});
  ASSERT_EQ(world->pair_rules().size(), 1u);
  EXPECT_TRUE(world->pair_rules()[0].check);
  EXPECT_THAT(VerdictsOf(*world, bent), ElementsAre(Verdict::kCollision));
  EXPECT_THAT(VerdictsOf(*world, {0, 0}), ElementsAre(Verdict::kFree));
  EXPECT_EQ(*Apply(world, std::vector{Check("a", "e")}), world) << "again, in the other order";
  world = *Apply(world, std::vector{Withdraw("a", "e")});
  EXPECT_THAT(world->pair_rules(), IsEmpty());
  EXPECT_THAT(VerdictsOf(*world, bent), ElementsAre(Verdict::kFree));
}

TEST(CheckedPairs, MayBeFixedToEachOther) {
  auto world = WorldWithArm();
  EXPECT_THAT(VerdictsOf(*world, {0, 0}), ElementsAre(Verdict::kFree));
  world = *Apply(world, std::vector{Check("e", "f")});
  EXPECT_THAT(VerdictsOf(*world, {0, 0}), ElementsAre(Verdict::kCollision)) << "0.05 m deep";
}

TEST(CheckedPairs, AndAllowancesOfOnePairEndEachOther) {
  auto world = *Apply(WorldWithArm(), std::vector{Check("a", "e")});
  world =
      *Apply(world, std::vector{MakeChange(AllowCollision{.pair = {{"arm", "a"}, {"arm", "e"}}})});
  ASSERT_EQ(world->pair_rules().size(), 1u);
  EXPECT_TRUE(world->pair_rules()[0].allowed);
  EXPECT_FALSE(world->pair_rules()[0].check);
  world = *Apply(world, std::vector{Check("a", "e")});
  EXPECT_FALSE(world->pair_rules()[0].allowed);
  EXPECT_TRUE(world->pair_rules()[0].check);
  // An allowance of all of the robot's links is a rule of another pair.
  world = *Apply(world, std::vector{MakeChange(AllowCollision{.pair = {{"arm"}, {"arm"}}})});
  EXPECT_THAT(VerdictsOf(*world, {0, 3}), ElementsAre(Verdict::kFree));
}

TEST(CheckedPairs, OfOtherThingsOnlyEndAnAllowance) {
  auto world = *Apply(WorldWithArm(),
                      std::vector{MakeChange(AllowCollision{.pair = {{"cup"}, {"arm", "e"}}})});
  ASSERT_EQ(world->pair_rules().size(), 1u);
  world = *Apply(
      world,
      std::vector{MakeChange(AllowCollision{.pair = {{"cup"}, {"arm", "e"}}, .check = true})});
  EXPECT_THAT(world->pair_rules(), IsEmpty());
}

TEST(CheckedPairs, HaveNoEndAndAreNotWithdrawnAtOnce) {
  const auto field_of = [](const AllowCollision& allow) {
    return FaultOf(Apply(WorldWithArm(), std::vector{MakeChange(allow)}).status())->field;
  };
  const NamedPair pair{{"arm", "a"}, {"arm", "e"}};
  EXPECT_EQ(field_of({.pair = pair, .withdraw = true, .check = true}), "check");
  EXPECT_EQ(
      field_of({.pair = pair, .expires = ExpiryAfter(std::chrono::seconds(1)), .check = true}),
      "expires_after");
  EXPECT_EQ(field_of({.pair = {{"arm", "a"}, {"arm", "z"}}, .check = true}), "pair.b.link");
}

// Many states, which are first tested by SIMD.
TEST(CheckedPairs, AreTheSameForManyStatesAtOnce) {
  const auto world =
      *Apply(WorldWithArm(), std::vector{Check("a", "e"), Check("a", "f"), Check("c", "f")});
  std::mt19937 random(1);
  std::uniform_real_distribution<> angle(-3, 3);
  std::vector<double> states(2 * 1'000);
  std::ranges::generate(states, [&] { return angle(random); });
  const std::vector<Verdict> many = VerdictsOf(*world, states);
  int collisions = 0;
  for (std::size_t k = 0; k < many.size(); ++k) {
    const std::vector<Verdict> one = VerdictsOf(*world, {states[2 * k], states[2 * k + 1]});
    ASSERT_EQ(many[k], one[0]) << k;
    collisions += one[0] == Verdict::kCollision ? 1 : 0;
  }
  EXPECT_GT(collisions, 50);
  EXPECT_LT(collisions, 900);
}

TEST(CheckedPairs, StopMotions) {
  const auto check = [](const WorldSnapshot& world) {
    const QueryBody body = BodyOf(world);
    std::vector<std::unique_ptr<BodyMotion>> edges;
    edges.push_back(std::make_unique<JointMotion>(world.FindRobot("arm")->model(), body,
                                                  Pose::Identity(), std::vector<double>{0, 0},
                                                  std::vector<double>{0, 3}));
    return CheckMotions(world, body, edges, {})->verdict;
  };
  const auto world = WorldWithArm();
  EXPECT_THAT(check(*world), ElementsAre(MotionVerdict::kFree));
  EXPECT_THAT(check(**Apply(world, std::vector{Check("a", "e")})),
              ElementsAre(MotionVerdict::kContact));
  EXPECT_THAT(check(**Apply(world, std::vector{Check("e", "f")})),
              ElementsAre(MotionVerdict::kContact))
      << "from the start, though they never move relative to each other";
}

}  // namespace
}  // namespace cwm::collision
