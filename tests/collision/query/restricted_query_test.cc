// Queries that are restricted to named objects, robots and links (QueryOptions::only).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "collision/motion/check_paths.h"
#include "collision/query/restrict_body.h"
#include "collision/query/sphere_check.h"
#include "tests/collision/query/plain_rows.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/query/rod_arm.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Only = std::vector<NamedThing>;

// The distances of a ball of 0.05 m at the place, nearest first.
std::vector<double> BallDistances(const WorldSnapshot& world, const Vector3& at, const Only& only) {
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.05}}});
  const std::vector<Pose> X_WB = {Pose(Eigen::Translation3d(at))};
  return GetDistances(world, body, X_WB, {.max_results = 9, .only = only})->distance_m;
}

PairColumns ArmDistances(const WorldSnapshot& world, const Only& only) {
  const RodArmStates arm(world);
  return *GetDistances(world, RestrictBody(arm.body, only), arm.Rows(),
                       {.max_results = 9, .only = only});
}

TEST(RestrictedQuery, TestsOnlyTheNamedObjects) {
  const auto world = WorldOf(
      {BallAt("a", {0.5, 0, 0}, 0.1), BallAt("b", {1, 0, 0}, 0.1), BallAt("c", {2, 0, 0}, 0.1)});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> at = {Pose::Identity()};
  const QueryOptions options{.margin_m = 1.9, .max_results = 9, .only = {{"c"}}};
  const PairColumns near = *GetDistances(*world, body, at, options);
  EXPECT_THAT(near.object, ElementsAre(2));
  EXPECT_THAT(near.distance_m, AreNear({1.8}));
  EXPECT_THAT(GetContacts(*world, body, at, options)->object, ElementsAre(2));
  EXPECT_THAT(CheckCollisions(*world, body, at, options)->object, ElementsAre(2));
  const std::vector<RayRow> rays = {{{-1, 0, 0}, {1, 0, 0}}};
  EXPECT_THAT(CastRays(*world, rays, options)->distance_m, AreNear({2.9}));
  const std::vector<Vector3> points = {{0, 0, 0}};
  EXPECT_THAT(SamplePoints(*world, points, options)->distance_m, AreNear({1.9}));
  EXPECT_THAT(BallDistances(*world, {0, 0, 0}, {{"c"}, {"a"}}), AreNear({0.35, 1.85}));
}

TEST(RestrictedQuery, MovesThroughWhatIsNotNamed) {
  const auto world = WorldOf({BallAt("a", {0.5, 0, 0}, 0.1), BallAt("c", {2, 0, 0}, 0.1)});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> ends = {Pose::Identity(), MakeTranslation(3, 0, 0)};
  const std::vector<Path> paths = {{.first_row = 0, .row_count = 2}};
  const auto columns =
      *CheckPaths(*world, body, PoseWaypoints(body, ends), paths, {.only = {{"c"}}});
  ASSERT_EQ(columns.verdict[0], MotionVerdict::kContact);
  EXPECT_EQ(columns.object[0], 1);
  EXPECT_NEAR(columns.hi[0], 1.8 / 3, kMaxBracketWidth);
}

TEST(RestrictedQuery, TestsOnlyTheNamedLinksOfARobot) {
  const auto world = WorldOf({PutRodArm(), BallAt("w", {0.5, 0.9, 0})});
  const Vector3 at(0.5, 0.3, 0);
  const double to_hand_m = std::sqrt(0.34) - 0.1;
  EXPECT_THAT(BallDistances(*world, at, {{"arm"}}), AreNear({0.2}));
  EXPECT_THAT(BallDistances(*world, at, {{"arm", "hand"}}), AreNear({to_hand_m}));
  EXPECT_THAT(BallDistances(*world, at, {{"arm", "hand"}, {"arm", "rod"}}), AreNear({0.2}));
  EXPECT_THAT(BallDistances(*world, at, {{"arm", "hand"}, {"arm"}}), AreNear({0.2}));
  EXPECT_THAT(BallDistances(*world, at, {{"arm"}, {"arm", "hand"}}), AreNear({0.2}));
  EXPECT_THAT(BallDistances(*world, at, {{"arm", "hand"}, {"w"}}), AreNear({to_hand_m, 0.5}));
  const QueryOptions hand{.only = {{"arm", "hand"}}};
  const std::vector<RayRow> rays = {{{-1, 0, 0}, {1, 0, 0}}};
  const RayColumns hits = *CastRays(*world, rays, hand);
  EXPECT_THAT(hits.distance_m, AreNear({1.95}));
  EXPECT_THAT(hits.object_part, ElementsAre(2));
  const std::vector<Vector3> points = {at};
  EXPECT_THAT(SamplePoints(*world, points, hand)->distance_m, AreNear({std::sqrt(0.34) - 0.05}));
}

TEST(RestrictedQuery, TestsOnlyTheNamedLinksOfItsRobot) {
  const auto world = WorldOf({PutRodArm(), BallAt("w", {0.5, 0.3, 0})});
  const double base_to_rod_m = 0.35, rod_to_hand_m = 0.4;
  const double rod_to_w_m = 0.2, hand_to_w_m = std::sqrt(0.34) - 0.1;
  EXPECT_THAT(ArmDistances(*world, {}).distance_m, AreNear({rod_to_w_m, base_to_rod_m}));
  EXPECT_THAT(ArmDistances(*world, {{"w"}}).distance_m, AreNear({rod_to_w_m}));
  EXPECT_THAT(ArmDistances(*world, {{"w"}, {"arm"}}).distance_m,
              AreNear({rod_to_w_m, base_to_rod_m}));
  EXPECT_THAT(ArmDistances(*world, {{"arm"}}).distance_m, AreNear({base_to_rod_m}));
  const PairColumns hand = ArmDistances(*world, {{"arm", "hand"}});
  EXPECT_THAT(hand.distance_m, AreNear({rod_to_hand_m, hand_to_w_m}));
  EXPECT_THAT(hand.body_part, ElementsAre(1, 2));
  EXPECT_THAT(ArmDistances(*world, {{"arm", "hand"}, {"w"}}).distance_m,
              AreNear({rod_to_hand_m, hand_to_w_m}));
  EXPECT_THAT(ArmDistances(*world, {{"arm", "hand"}, {"arm"}}).distance_m,
              AreNear({rod_to_hand_m}));
}

TEST(RestrictedQuery, NamesAnAttachedObjectByItselfOrByItsLink) {
  // A box of 0.1 m at x = 1.2, on the hand.
  std::vector<Change> changes = {PutRodArm(), BallAt("w", {0.5, 0.3, 0}),
                                 BallAt("v", {1.2, 0.3, 0})};
  for (const Change& change : HeldBox()) changes.push_back(change);
  const auto world = WorldOf(changes);
  const double box_to_v_m = 0.2, rod_to_box_m = 0.6;
  const double box_to_w_m = std::hypot(0.65, 0.25) - 0.05;
  EXPECT_THAT(ArmDistances(*world, {{"arm", "hand"}, {"v"}}).distance_m,
              AreNear({box_to_v_m, 0.4}));
  const PairColumns of_box = ArmDistances(*world, {{"box"}});
  EXPECT_THAT(of_box.distance_m, AreNear({box_to_v_m, rod_to_box_m, box_to_w_m}));
  EXPECT_THAT(of_box.body_part, ElementsAre(3, 3, 3));
}

TEST(RestrictedQuery, IsAnsweredInLanesAsPairByPair) {
  std::mt19937 random(7);
  std::vector<Change> changes = {PutRodArm()};
  std::uniform_real_distribution<double> angle(-3, 3), radius(0.4, 1.1);
  for (int k = 0; k < 12; ++k) {
    const double at = angle(random), r = radius(random);
    changes.push_back(BoxAt("object_" + std::to_string(k), {0.1, 0.2, 0.1},
                            MakeTranslation(r * std::cos(at), r * std::sin(at), 0)));
  }
  const auto world = WorldOf(changes);
  RodArmStates arm(*world);
  std::uniform_real_distribution<double> turn(-3, 3), grip(-1, 0.5);
  arm.rows.clear();
  for (int k = 0; k < 600; ++k) arm.rows.insert(arm.rows.end(), {turn(random), grip(random)});
  for (const Only& only : std::vector<Only>{{{"object_3"}, {"object_7"}},
                                            {{"arm", "hand"}},
                                            {{"arm", "base"}, {"object_1"}},
                                            {{"arm"}}}) {
    const QueryBody body = RestrictBody(arm.body, only);
    const QueryOptions options{.only = only};
    const JointRows rows = arm.Rows();
    EXPECT_TRUE(SphereCheck::Make(*world, body, rows, options).has_value());
    const auto verdicts = CheckCollisions(*world, body, rows, options)->verdict;
    EXPECT_EQ(verdicts, CheckCollisions(*world, body, PlainRows(rows), options)->verdict);
    const auto all = CheckCollisions(*world, arm.body, rows, {})->verdict;
    EXPECT_LT(std::ranges::count(verdicts, Verdict::kCollision),
              std::ranges::count(all, Verdict::kCollision));
    EXPECT_GT(std::ranges::count(verdicts, Verdict::kCollision), 0);
  }
}

TEST(RestrictedQuery, FindsNothingOfAnUnknownName) {
  const auto world = WorldOf({PutRodArm(), BallAt("w", {0.5, 0, 0})});
  EXPECT_THAT(ArmDistances(*world, {{"nothing"}}).distance_m, IsEmpty());
}

}  // namespace
}  // namespace cwm::collision
