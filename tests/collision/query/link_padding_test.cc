// Paddings of links, which count against the world alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "collision/motion/body_motion.h"
#include "collision/motion/check_motions.h"
#include "collision/motion/check_paths.h"
#include "collision/query/attached_objects.h"
#include "collision/query/robot_body.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeChange;

// The arm of ThreeBalls: balls a, c and e of 0.1 m radius, `more_c_m` and `more_e_m` larger, or so
// much padded.
std::shared_ptr<const RobotGeometry> BallArm(double more_c_m, double more_e_m, bool by_padding) {
  RobotDescription description =
      *ReadUrdf(testing::Robot(testing::ThreeBalls()), testing::NoMeshes);
  const auto more_m = [&](const std::string& link) {
    return link == "c" ? more_c_m : link == "e" ? more_e_m : 0;
  };
  for (Link& link : description.links) {
    if (by_padding) break;
    for (CollisionGeometry& geometry : link.collisions) {
      std::get<Sphere>(geometry.shape).radius_m += more_m(link.name);
    }
  }
  RobotModel model = **MakeRobotModel(description, nullptr);
  for (ModelLink& link : model.links) link.padding_m = by_padding ? more_m(link.name) : 0;
  return PrepareRobot(std::make_shared<const RobotModel>(model), std::nullopt);
}

std::vector<double> RandomStates(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<> angle(-3, 3);
  std::vector<double> states;
  for (std::size_t k = 0; k < 2 * count; ++k) states.push_back(angle(random));
  return states;
}

std::vector<Verdict> VerdictsOf(const WorldSnapshot& world, const RobotGeometry& robot,
                                const QueryBody& body, const std::vector<double>& states) {
  const JointRows rows(*robot.model, robot.model->all, {.base = {0, 0}, .rows = states});
  const auto found = CheckCollisions(world, body, rows, {});
  EXPECT_TRUE(found.ok()) << found.status();
  return found->verdict;
}

// A ball of 0.1 m with a padding of 0.05 m collides exactly where a ball of 0.15 m does. Few rows
// are tested pair by pair, many by SIMD first.
TEST(LinkPadding, CollidesWhereALargerBallDoes) {
  std::mt19937 random(3);
  const auto world = RandomWorld(12, random, /*with_meshes=*/true);
  const auto padded = BallArm(0.05, 0.15, true), larger = BallArm(0.05, 0.15, false);
  const std::vector<double> states = RandomStates(2'000, random);
  const std::vector<double> few(states.begin(), states.begin() + 200);
  const QueryBody padded_body = BodyFromRobot(*padded, RobotScope::kWorld);
  const QueryBody larger_body = BodyFromRobot(*larger, RobotScope::kWorld);
  const auto expected = VerdictsOf(*world, *larger, larger_body, states);
  EXPECT_EQ(VerdictsOf(*world, *padded, padded_body, states), expected);
  EXPECT_EQ(VerdictsOf(*world, *padded, padded_body, few),
            std::vector(expected.begin(), expected.begin() + 100));
  const auto collisions = std::ranges::count(expected, Verdict::kCollision);
  EXPECT_GT(collisions, 200);
  EXPECT_LT(collisions, 1'800);
  const QueryBody bare = BodyFromRobot(*BallArm(0, 0, true), RobotScope::kWorld);
  EXPECT_LT(std::ranges::count(VerdictsOf(*world, *padded, bare, states), Verdict::kCollision),
            collisions);
}

TEST(LinkPadding, DoesNotCountBetweenLinks) {
  std::mt19937 random(4);
  const auto padded = BallArm(0.3, 0.3, true), bare = BallArm(0, 0, true);
  const std::vector<double> states = RandomStates(1'000, random);
  for (const std::size_t count : {std::size_t{50}, std::size_t{1'000}}) {
    const std::vector<double> some(states.begin(),
                                   states.begin() + static_cast<std::ptrdiff_t>(2 * count));
    EXPECT_EQ(VerdictsOf({}, *padded, BodyFromRobot(*padded, RobotScope::kSelf), some),
              VerdictsOf({}, *bare, BodyFromRobot(*bare, RobotScope::kSelf), some));
  }
}

TEST(LinkPadding, CanBeReplacedForAQuery) {
  const auto robot = BallArm(0.05, 0.15, true);
  QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  SetPaddings({{"c", 0}, {"a", 0.01}}, body);
  EXPECT_THAT(body.frame_padding_m, ElementsAre(0.01, 0, 0, 0, 0.15)) << "links a b c d e";
  SetPaddings({{"*", 0}}, body);
  EXPECT_THAT(body.frame_padding_m, IsEmpty());
  SetPaddings({{"*", 0.2}, {"e", 0.1}}, body);
  EXPECT_THAT(body.frame_padding_m, ElementsAre(0.2, 0.2, 0.2, 0.2, 0.1));
}

// The bead is 0.02 m from ball c and 0.12 m from ball e.
TEST(LinkPadding, IsAMarginOfContactsAndNotOfDistances) {
  const auto robot = BallArm(0.03, 0.03, true);
  const auto world =
      WorldOf({PutOf("bead", {{.shape = Sphere{0.05}}}, MakeTranslation(0.5, 0.17, 0)),
               PutOf("far", {{.shape = Sphere{0.05}}}, MakeTranslation(1, 0.27, 0))});
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kWorld);
  const std::vector<double> state = {0, 0};
  const JointRows rows(*robot->model, robot->model->all, {.base = state, .rows = state});
  const PairColumns contacts = *GetContacts(*world, body, rows, {});
  EXPECT_THAT(contacts.body_part, ElementsAre(1));
  EXPECT_NEAR(contacts.distance_m[0], 0.02, 1e-9);
  EXPECT_NEAR(GetDistances(*world, body, rows, {})->distance_m[0], 0.02, 1e-9);
  const auto with_rule = *Apply(
      world, std::vector{MakeChange(SetPairMargin{.pair = {{"*"}, {"bead"}}, .margin_m = 0.01})});
  EXPECT_THAT(GetContacts(*with_rule, body, rows, {})->body_part, IsEmpty())
      << "a rule takes the place of margins, and of paddings";
}

// Whoever is asked about: the robot, or what is near it.
TEST(LinkPadding, HoldsForARobotThatIsAnObstacle) {
  PutRobot put;
  put.name = "arm";
  put.robot = BallArm(0.03, 0, true);
  put.state = {0, 0};
  const auto world =
      WorldOf({MakeChange(put), PutOf("pad", {{.shape = Sphere{0.05}}}, MakeTranslation(0, 0, 3))});
  const QueryBody bead = BodyFromShapes({{.shape = Sphere{0.05}}});
  const std::vector<Pose> poses = {MakeTranslation(0.5, 0.17, 0), MakeTranslation(0.5, 0.19, 0),
                                   MakeTranslation(1, 0.17, 0)};
  EXPECT_THAT(CheckCollisions(*world, bead, poses, {})->verdict,
              ElementsAre(Verdict::kCollision, Verdict::kFree, Verdict::kFree));
  const auto ruled = *Apply(
      world,
      std::vector{MakeChange(SetPairMargin{.pair = {{"arm", "e"}, {"*"}}, .margin_m = 0.1})});
  EXPECT_THAT(CheckCollisions(*ruled, bead, poses, {})->verdict,
              ElementsAre(Verdict::kCollision, Verdict::kFree, Verdict::kCollision));
  // What the robot carries is part of it.
  const auto carried = *Apply(
      world, std::vector{MakeChange(AttachObject{.name = "pad", .robot = "arm", .link = "a"})});
  const QueryBody pad = BodyFromObject(*carried->Find("pad"));
  EXPECT_THAT(CheckCollisions(*carried, pad, poses, {})->verdict, Each(Verdict::kFree));
}

// A robot of spheres that is checked by SIMD, with a padded robot as an obstacle.
TEST(LinkPadding, OfAnotherRobotHoldsForManyStatesAtOnce) {
  std::mt19937 random(5);
  const auto world_with = [](bool by_padding) {
    PutRobot put;
    put.name = "other";
    put.robot = BallArm(0.05, 0.15, by_padding);
    put.state = {0.3, 0.4};
    put.X_WB = MakeTranslation(0.6, 0.5, 0);
    return WorldOf({MakeChange(put)});
  };
  const auto robot = BallArm(0, 0, true);
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kWorld);
  const std::vector<double> states = RandomStates(2'000, random);
  const auto verdicts = VerdictsOf(*world_with(true), *robot, body, states);
  EXPECT_EQ(verdicts, VerdictsOf(*world_with(false), *robot, body, states));
  EXPECT_GT(std::ranges::count(verdicts, Verdict::kCollision), 50);
}

// Edges of padded balls are those of larger balls, also where SIMD certifies them.
TEST(LinkPadding, HoldsAlongManyPaths) {
  std::mt19937 random(6);
  const auto world = RandomWorld(12, random, /*with_meshes=*/false);
  std::vector<double> states = RandomStates(600, random);  // short edges from every other one
  std::vector<Path> paths;
  for (std::size_t k = 0; k < 300; ++k) {
    paths.push_back({.first_row = 2 * k});
    for (std::size_t i = 4 * k; i < 4 * k + 2; ++i) {
      states[i + 2] = std::clamp(states[i] + 0.1 * states[i + 2], -3.0, 3.0);
    }
  }
  const auto check = [&](bool by_padding) {
    const auto robot = BallArm(0.05, 0.15, by_padding);
    const QueryBody body = BodyFromRobot(*robot, RobotScope::kWorld);
    const JointRows rows(*robot->model, robot->model->all, {.base = {0, 0}, .rows = states});
    return *CheckPaths(*world, body, JointWaypoints(*robot->model, body, rows), paths, {});
  };
  const MotionColumns padded = check(true), larger = check(false);
  EXPECT_EQ(padded.verdict, larger.verdict);
  int contacts = 0;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    if (larger.verdict[k] != MotionVerdict::kContact) continue;
    ++contacts;
    EXPECT_LE(padded.lo[k], larger.hi[k]) << k;
    EXPECT_GE(padded.hi[k], larger.lo[k]) << k;
  }
  EXPECT_GT(contacts, 50);
  EXPECT_LT(contacts, 290);
}

// Ball e turns towards a wall at y = 0.9 with its shoulder at the origin and its elbow straight: it
// comes within 0.2 m of it, its padding and its radius, where sin(turn) = 0.7.
TEST(LinkPadding, StopsMotions) {
  const auto robot = BallArm(0, 0.1, true);
  const auto world =
      WorldOf({PutOf("wall", {{.shape = Box{{4, 1, 4}}}}, MakeTranslation(0, 1.4, 0))});
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kWorld);
  std::vector<std::unique_ptr<BodyMotion>> edges;
  const std::vector<double> from = {0, 0}, to = {1, 0};
  edges.push_back(std::make_unique<JointMotion>(*robot->model, body, Pose::Identity(), from, to));
  const MotionColumns found = *CheckMotions(*world, body, edges, {});
  EXPECT_THAT(found.verdict, ElementsAre(MotionVerdict::kContact));
  EXPECT_LE(found.lo[0], std::asin(0.7));
  EXPECT_GE(found.hi[0], std::asin(0.7) - 1e-9);
  EXPECT_NEAR(found.lo[0], std::asin(0.7), 2e-4);
}

}  // namespace
}  // namespace cwm::collision
