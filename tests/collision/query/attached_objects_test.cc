// Robots with attached objects, and robots as obstacles.
#include "collision/query/attached_objects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "collision/geometry/tessellate.h"
#include "collision/query/sphere_check.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/query/plain_rows.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using testing::Arm;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeChange;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

// Links "base" (a box of 0.2 m at the origin), "rod" (turns about the base's z axis; a ball of 0.05
// m at x = 0.5), and "hand" (fixed to the rod at x = 1; a ball of 0.05 m).
const char* const kUrdf =
    "<robot name=\"arm\"><link name=\"base\"><collision><geometry><box size=\"0.2 0.2 0.2\"/>"
    "</geometry></collision></link>"
    "<link name=\"rod\"><collision><origin xyz=\"0.5 0 0\"/><geometry><sphere radius=\"0.05\"/>"
    "</geometry></collision></link>"
    "<link name=\"hand\"><collision><geometry><sphere radius=\"0.05\"/></geometry></collision>"
    "</link>"
    "<joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"rod\"/>"
    "<axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\"/></joint>"
    "<joint name=\"grip\" type=\"prismatic\"><origin xyz=\"1 0 0\"/><parent link=\"rod\"/>"
    "<child link=\"hand\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\"/></joint></robot>";
const char* const kSrdf = "<robot name=\"arm\"/>";

SnapshotPtr With(const SnapshotPtr& world, const std::vector<Change>& changes) {
  auto next = Apply(world, changes);
  EXPECT_TRUE(next.ok()) << next.status();
  return *next;
}

Change Robot(const std::string& name, const Pose& X_WB = Pose::Identity()) {
  PutRobot put = testing::PutArm(name, Arm(kUrdf, kSrdf));
  put.X_WB = X_WB;
  return MakeChange(put);
}

// A box of 0.1 m, attached 0.2 m beyond the hand.
Change Held(const std::string& name) {
  return PutOf(name, {{.X_FS = Pose::Identity(), .shape = Box{{0.1, 0.1, 0.1}}}},
               MakeTranslation(0, 0, 5));
}
Change Attach(const std::string& name, const Pose& X_LO = MakeTranslation(0.2, 0, 0),
              std::vector<std::string> touch_links = {}, const std::string& link = "hand") {
  return MakeChange(AttachObject{.name = name,
                                 .robot = "arm",
                                 .link = link,
                                 .X_LO = X_LO,
                                 .touch_links = std::move(touch_links)});
}
Change Ball(const std::string& name, const Vector3& at, double radius_m = 0.05) {
  return PutOf(name, {{.X_FS = Pose::Identity(), .shape = Sphere{radius_m}}},
               Pose(Eigen::Translation3d(at)));
}

struct ArmQuery {
  QueryBody body;
  std::vector<double> rows;  // turn, grip
  std::shared_ptr<const WorldRobot> robot;

  JointRows Rows() const {
    return {robot->model(),
            robot->model().all,
            {.X_WB = robot->X_WB, .base = robot->state, .rows = rows}};
  }
};

ArmQuery ArmIn(const WorldSnapshot& world, std::vector<double> rows,
               RobotScope scope = RobotScope::kBoth) {
  const WorldRobotPtr robot = world.FindRobot("arm");
  return {WithAttachedObjects(BodyFromRobot(*robot, scope), world, *robot, scope), std::move(rows),
          robot};
}

std::vector<Verdict> Check(const WorldSnapshot& world, std::vector<double> rows,
                           const QueryOptions& options = {}, RobotScope scope = RobotScope::kBoth) {
  const ArmQuery arm_query = ArmIn(world, std::move(rows), scope);
  return CheckCollisions(world, arm_query.body, arm_query.Rows(), options)->verdict;
}

constexpr Verdict kFree = Verdict::kFree, kHit = Verdict::kCollision;
constexpr double kRight = std::numbers::pi / 2;

TEST(AttachedObjects, MeetWhatTheBareArmDoesNot) {
  const SnapshotPtr bare = WorldOf({Robot("arm"), Held("box"), Ball("ball", {0, 1.2, 0})});
  EXPECT_THAT(Check(*bare, {0, 0, kRight, 0}), ElementsAre(kFree, kFree));
  const SnapshotPtr world = With(bare, {Attach("box")});
  EXPECT_THAT(Check(*world, {0, 0, kRight, 0}), ElementsAre(kFree, kHit));
  const ArmQuery arm_query = ArmIn(*world, {kRight, 0});
  const auto result = *CheckCollisions(*world, arm_query.body, arm_query.Rows(), {});
  EXPECT_EQ(world->ObstacleAt(static_cast<std::size_t>(result.object[0])).name, "ball");
  EXPECT_EQ(arm_query.body.AttachedIn(arm_query.body.FrameOf(result.body_part[0]))->object->name,
            "box");
}

TEST(AttachedObjects, AreNoObstaclesToTheirRobot) {
  const SnapshotPtr world = WorldOf({Robot("arm"), Held("box"), Attach("box", Pose::Identity())});
  EXPECT_THAT(Check(*world, {0, 0}), ElementsAre(kFree)) << "around the very hand";
  // For other bodies both are obstacles.
  const QueryBody ball = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.01}}});
  const Pose at = world->Find("box")->X_WO * MakeTranslation(0, 0.048, 0.048);
  const auto result = *CheckCollisions(*world, ball, {&at, 1}, {});
  EXPECT_EQ(result.verdict[0], kHit);
  EXPECT_EQ(world->ObstacleAt(static_cast<std::size_t>(result.object[0])).name, "box");
}

TEST(AttachedObjects, MeetTheLinksThatTheyMayNotTouch) {
  const auto world = [](std::vector<std::string> touch) {
    return WorldOf({Robot("arm"), Held("box"), Attach("box", MakeTranslation(-0.3, 0, 0), touch)});
  };
  // When it is drawn in by 0.2 m, the box touches the ball of the rod.
  const std::vector<double> drawn_in = {0, -0.2};
  EXPECT_THAT(Check(*world({}), {0, 0}), ElementsAre(kFree));
  EXPECT_THAT(Check(*world({}), drawn_in), ElementsAre(kHit));
  EXPECT_THAT(Check(*world({}), drawn_in, {}, RobotScope::kSelf), ElementsAre(kHit));
  EXPECT_THAT(Check(*world({}), drawn_in, {}, RobotScope::kWorld), ElementsAre(kFree));
  EXPECT_THAT(Check(*world({"rod"}), drawn_in), ElementsAre(kFree));
  QueryOptions ignoring;
  ignoring.ignore_pairs = {{{"box"}, {"arm", "rod"}}};
  EXPECT_THAT(Check(*world({}), drawn_in, ignoring), ElementsAre(kFree));
  ignoring.ignore_pairs = {{{"box"}, {"arm", "base"}}};
  EXPECT_THAT(Check(*world({}), drawn_in, ignoring), ElementsAre(kHit));
  ignoring.ignore_pairs = {{{"box"}, {"arm"}}};
  EXPECT_THAT(Check(*world({}), drawn_in, ignoring), ElementsAre(kFree));
  const ArmQuery arm_query = ArmIn(*world({}), drawn_in);
  const auto result = *CheckCollisions(*world({}), arm_query.body, arm_query.Rows(), {});
  EXPECT_THAT(result.object, ElementsAre(kSelfObject));
  EXPECT_EQ(arm_query.body.FrameOf(result.body_part[0]), 3) << "the attached part comes first";
  EXPECT_EQ(arm_query.body.FrameOf(result.object_part[0]), 1);
}

TEST(AttachedObjects, MeetEachOtherUnlessTheyAreOnOneLink) {
  const auto world = [](const std::string& link) {
    return WorldOf({Robot("arm"), Held("a"), Held("b"), Attach("a"),
                    Attach("b", MakeTranslation(link == "hand" ? 0.25 : 1.25, 0, 0), {}, link)});
  };
  EXPECT_THAT(Check(*world("hand"), {0, 0}), ElementsAre(kFree));
  EXPECT_THAT(Check(*world("rod"), {0, 0, 0, 0.5}), ElementsAre(kHit, kFree));
}

TEST(AttachedObjects, KeepTheirMargins) {
  auto put = Held("box");
  std::get<PutObject>(put.what).margin_m = 0.03;
  const SnapshotPtr world =
      WorldOf({Robot("arm"), put, Attach("box"), Ball("ball", {1.2, 0.12, 0})});  // 2 cm away
  EXPECT_THAT(Check(*world, {0, 0}), ElementsAre(kHit));
  const SnapshotPtr close = With(world, {MakeChange(SetPairMargin{{{"box"}, {"ball"}}, 0.019})});
  EXPECT_THAT(Check(*close, {0, 0}), ElementsAre(kFree));
  const SnapshotPtr of_arm = With(world, {MakeChange(SetPairMargin{{{"arm"}, {"ball"}}, 0.0})});
  EXPECT_THAT(Check(*of_arm, {0, 0}), ElementsAre(kHit)) << "the box has a name of its own";
}

TEST(AttachedObjects, MayReachIntoWhatSupportsThem) {
  auto put = Held("box");
  std::get<PutObject>(put.what).supported_by = "table";
  const auto world = [&](double deep_m) {
    return WorldOf({Robot("arm", MakeTranslation(0, 0, 1)), put, Attach("box"),
                    PutOf("table", {{.X_FS = Pose::Identity(), .shape = Box{{0.3, 0.3, 0.1}}}},
                          MakeTranslation(1.2, 0, 0.9 + deep_m))});
  };
  EXPECT_THAT(Check(*world(0.0049), {0, 0}), ElementsAre(kFree));
  EXPECT_THAT(Check(*world(0.0051), {0, 0}), ElementsAre(kHit));
  QueryOptions options;
  options.support_tolerance_m = 0.02;
  EXPECT_THAT(Check(*world(0.0199), {0, 0}, options), ElementsAre(kFree));
  EXPECT_THAT(Check(*world(0.0201), {0, 0}, options), ElementsAre(kHit));
  options.support_tolerance_m = 0;
  EXPECT_THAT(Check(*world(0.001), {0, 0}, options), ElementsAre(kHit));
  const auto ruled = With(world(0.001), {MakeChange(SetPairMargin{{{"box"}, {"table"}}, 0.0})});
  EXPECT_THAT(Check(*ruled, {0, 0}), ElementsAre(kHit)) << "the rule goes before";
  // Contacts use the margin, distances are geometric.
  const ArmQuery arm_query = ArmIn(*world(0.0049), {0, 0});
  EXPECT_THAT(GetContacts(*world(0.0049), arm_query.body, arm_query.Rows(), {})->distance_m,
              IsEmpty());
  const auto nearest = *GetDistances(*world(0.0049), arm_query.body, arm_query.Rows(), {});
  EXPECT_NEAR(nearest.distance_m[0], -0.0049, 1e-9);
}

TEST(AskingObjects, MayReachIntoWhatSupportsThem) {
  auto put = PutOf("cup", {{.X_FS = Pose::Identity(), .shape = Cylinder{0.03, 0.1}}},
                   MakeTranslation(0, 0, 0.047));
  std::get<PutObject>(put.what).supported_by = "table";
  const SnapshotPtr world = WorldOf(
      {put, PutOf("table", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}}, Pose::Identity())});
  const QueryBody cup = BodyFromObject(*world->Find("cup"));
  const std::vector<Pose> poses = {MakeTranslation(0, 0, 0.047), MakeTranslation(0, 0, 0.0449)};
  EXPECT_THAT(CheckCollisions(*world, cup, poses, {})->verdict, ElementsAre(kFree, kHit));
}

// Only some of many small overlapping triangles are measured, and none need be as deep as the mesh.
TEST(AskingObjects, WithOpenMeshesAreNotFreeWhereTheyAreSunkIntoWhatSupportsThem) {
  TriangleMesh open = Tessellate(Sphere{0.1}, 5e-5);
  open.triangles.pop_back();
  auto put = PutOf("residual", {{.X_FS = Pose::Identity(), .shape = MakeMesh(std::move(open))}},
                   MakeTranslation(0, 0, 1));
  std::get<PutObject>(put.what).supported_by = "table";
  const SnapshotPtr world =
      WorldOf({put, PutOf("table", {{.X_FS = Pose::Identity(), .shape = Box{{2, 2, 0.2}}}},
                          MakeTranslation(0, 0, -0.1))});
  const QueryBody residual = BodyFromObject(*world->Find("residual"));
  std::vector<Pose> poses;
  for (const double deep_m : {0.002, 0.01, 0.03, 0.08}) {
    poses.push_back(MakeTranslation(0, 0, 0.1 - deep_m));
  }
  const auto verdicts = CheckCollisions(*world, residual, poses, {})->verdict;
  EXPECT_EQ(verdicts[0], kFree);
  for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_NE(verdicts[i], kFree) << i;
}

TEST(AskingObjects, ThatAreAttachedStayWithWhatHoldsThem) {
  const SnapshotPtr world =
      WorldOf({Robot("arm"), Held("box"), Held("lid"), Attach("box", MakeTranslation(0.05, 0, 0)),
               Attach("lid", MakeTranslation(0.1, 0, 0))});
  const QueryBody box = BodyFromObject(*world->Find("box"));
  const std::vector<Pose> poses = {world->Find("box")->X_WO, MakeTranslation(0.5, 0, 0)};
  EXPECT_THAT(CheckCollisions(*world, box, poses, {})->verdict, ElementsAre(kFree, kHit))
      << "the rod is not what holds it";
}

TEST(RobotsOfTheWorld, AreMetByShapesRaysAndPoints) {
  const SnapshotPtr world = WorldOf({Robot("arm", MakeTranslation(0, 0, 2)), Ball("z", {0, 3, 2})});
  const QueryBody ball = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> poses = {MakeTranslation(0.6, 0, 2), MakeTranslation(0.75, 0, 2)};
  const auto result = *CheckCollisions(*world, ball, poses, {});
  EXPECT_THAT(result.verdict, ElementsAre(kHit, kFree));
  EXPECT_EQ(result.object[0], 1) << "after the one object";
  EXPECT_EQ(world->ObstacleAt(1).name, "arm");
  EXPECT_EQ(result.object_part[0], 1) << "of the rod";
  QueryOptions ignoring;
  ignoring.ignore = {"arm"};
  EXPECT_THAT(CheckCollisions(*world, ball, poses, ignoring)->verdict, ElementsAre(kFree, kFree));

  const auto near = *GetDistances(*world, ball, poses, {});
  EXPECT_NEAR(near.distance_m[1], 0.1, 1e-9);
  const RayRow ray{.origin = {0.5, 1, 2}, .direction = {0, -1, 0}};
  const auto hit = *CastRays(*world, {&ray, 1}, {});
  EXPECT_THAT(hit.hit, ElementsAre(1));
  EXPECT_NEAR(hit.distance_m[0], 0.95, 1e-9);
  EXPECT_THAT(hit.object, ElementsAre(1));
  EXPECT_THAT(hit.object_part, ElementsAre(1));
  const Vector3 point(0.5, 0.15, 2);
  const auto sample = *SamplePoints(*world, {&point, 1}, {});
  EXPECT_NEAR(sample.distance_m[0], 0.1, 1e-9);
  EXPECT_THAT(sample.object, ElementsAre(1));
}

TEST(RobotsOfTheWorld, AreMetByOtherRobotsWhereTheirStatePutsThem) {
  const SnapshotPtr world = WorldOf({Robot("arm"), Robot("other", MakeTranslation(0, 2.05, 0))});
  // Straight up, this hand is at (0, 1), and the other robot's is at (1, 2.05).
  EXPECT_THAT(Check(*world, {kRight, 0}), ElementsAre(kFree));
  SetRobotState set{
      .name = "other", .X_WB = {}, .joints = {.named = {}, .values = {{"turn", -kRight}}}};
  const SnapshotPtr turned = With(world, {MakeChange(set)});
  EXPECT_THAT(Check(*turned, {0, 0, kRight, 0}), ElementsAre(kFree, kHit));
  QueryOptions options;
  options.ignore_pairs = {{{"arm", "hand"}, {"other", "hand"}}};
  EXPECT_THAT(Check(*turned, {kRight, 0}, options), ElementsAre(kFree));
  options.ignore_pairs = {{{"arm", "hand"}, {"other", "rod"}}};
  EXPECT_THAT(Check(*turned, {kRight, 0}, options), ElementsAre(kHit));
  options.ignore_pairs = {{{"arm"}, {"other"}}};
  EXPECT_THAT(Check(*turned, {kRight, 0}, options), ElementsAre(kFree));
  const SnapshotPtr wide =
      With(world, {MakeChange(SetPairMargin{{{"other", "hand"}, {"arm"}}, 2.0})});
  EXPECT_THAT(Check(*wide, {kRight, 0}), ElementsAre(kHit));
  const SnapshotPtr by_base =
      With(world, {MakeChange(SetPairMargin{{{"other", "base"}, {"arm"}}, 0.8})});
  EXPECT_THAT(Check(*by_base, {0, 0, kRight, 0}), ElementsAre(kFree, kFree))
      << "the base is a metre away, and only it keeps 0.8";
}

// The SIMD code decides many states; its verdicts must be those of the pair by pair path.
TEST(RobotsOfTheWorld, AreMetInLanesAsPairByPair) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-3, 3), slide(-1, 1);
  std::vector<Change> changes = {Robot("arm")};
  for (int k = 0; k < 6; ++k) {
    changes.push_back(Robot("other" + std::to_string(k), RandomPose(random, 1.2)));
  }
  const SnapshotPtr world = WorldOf(changes);
  const WorldRobotPtr robot = world->FindRobot("arm");
  std::vector<double> rows;
  for (int k = 0; k < 2000; ++k) rows.insert(rows.end(), {angle(random), slide(random)});
  const JointRows states(robot->model(), robot->model().all,
                         {.X_WB = robot->X_WB, .base = robot->state, .rows = rows});
  QueryBody spheres =
      BodyFromSpheres(*robot->robot, *robot->robot->bounding_spheres, RobotScope::kBoth);
  spheres.self = "arm";
  for (const QueryBody& body : {BodyFromRobot(*robot, RobotScope::kBoth), spheres}) {
    const auto in_lanes = *CheckCollisions(*world, body, states, {});
    const auto by_pairs = *CheckCollisions(*world, body, PlainRows(states), {});
    EXPECT_EQ(in_lanes.verdict, by_pairs.verdict);
    EXPECT_EQ(in_lanes.object, by_pairs.object);
    EXPECT_GT(std::ranges::count(in_lanes.verdict, kFree), 200);
    EXPECT_GT(std::ranges::count(in_lanes.verdict, kHit), 200);
  }
}

TEST(RobotsOfTheWorld, BreakTiesByNameAmongObjects) {
  const auto between = [](const std::string& name) {
    return WorldOf({Robot(name, MakeTranslation(-1, 0, 0)), Ball("m", {0, 0.5, 0})});
  };
  // The point is equally far from the hand and from the ball.
  const Vector3 point(0, 0.25, 0);
  const auto named = [&](const SnapshotPtr& world) {
    const auto result = *SamplePoints(*world, {&point, 1}, {});
    return world->ObstacleAt(static_cast<std::size_t>(result.object[0])).name;
  };
  EXPECT_EQ(named(between("a")), "a");
  EXPECT_EQ(named(between("z")), "m");
}

TEST(AttachedObjects, OfSpheresAreAskedExactly) {
  const SnapshotPtr world =
      WorldOf({Robot("arm"), Held("box"), Attach("box"), Ball("ball", {0, 1.2, 0})});
  const WorldRobotPtr robot = world->FindRobot("arm");
  ASSERT_NE(robot->robot->bounding_spheres, nullptr);
  QueryBody body =
      BodyFromSpheres(*robot->robot, *robot->robot->bounding_spheres, RobotScope::kBoth);
  body = WithAttachedObjects(std::move(body), *world, *robot, RobotScope::kBoth);
  body.self = "arm";
  std::vector<double> rows;
  for (int k = 0; k < 300; ++k) rows.insert(rows.end(), {k % 2 == 0 ? 0.0 : kRight, 0.0});
  const JointRows states(robot->model(), robot->model().all,
                         {.X_WB = robot->X_WB, .base = robot->state, .rows = rows});
  const auto result = *CheckCollisions(*world, body, states, {});
  for (std::size_t k = 0; k < 300; ++k)
    ASSERT_EQ(result.verdict[k], k % 2 == 0 ? kFree : kHit) << k;
}

// Attached objects with margins on two links, one of which may sink into its support, and rules
// that allow pairs or set margins below the request's: spheres must prove no more than the pairs.
TEST(AttachedObjects, AreAskedInLanesAsPairByPair) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-3, 3), slide(-1, 1);
  SnapshotPtr world = RandomWorld(20, random, true);
  Change far_one = Held("far_one");
  std::get<PutObject>(far_one.what).margin_m = 0.03;
  const std::string first = world->ObstacleAt(0).name, second = world->ObstacleAt(1).name;
  const auto rule = [](const NamedThing& a, const NamedThing& b) { return NamedPair{a, b}; };
  world =
      With(world, {Robot("arm"), Held("box"), Attach("box", RandomPose(random, 0.2)), far_one,
                   Attach("far_one", MakeTranslation(0.1, 0.3, 0), {"base"}, "rod"),
                   MakeChange(AllowCollision{.pair = rule({"arm", "rod"}, {first})}),
                   MakeChange(AllowCollision{.pair = rule({"box"}, {"arm", "base"})}),
                   MakeChange(SetPairMargin{.pair = rule({"arm"}, {second}), .margin_m = 0.001})});
  std::vector<double> rows;
  for (int k = 0; k < 3000; ++k) rows.insert(rows.end(), {angle(random), slide(random)});
  const ArmQuery of_links = ArmIn(*world, rows);
  const WorldRobotPtr& robot = of_links.robot;
  QueryBody spheres =
      BodyFromSpheres(*robot->robot, *robot->robot->bounding_spheres, RobotScope::kBoth);
  spheres.self = "arm";
  spheres = WithAttachedObjects(std::move(spheres), *world, *robot, RobotScope::kBoth);
  const JointRows states = of_links.Rows();
  // The second margin is less than the rule's, so that the rule widens it.
  for (const double margin_m : {0.01, 0.0005, 0.0}) {
    const QueryOptions options{.margin_m = margin_m};
    for (const QueryBody& body : {of_links.body, spheres}) {
      ASSERT_TRUE(SphereCheck::Make(*world, body, states, options).has_value());
      const auto in_lanes = *CheckCollisions(*world, body, states, options);
      const auto by_pairs = *CheckCollisions(*world, body, PlainRows(states), options);
      EXPECT_EQ(in_lanes.verdict, by_pairs.verdict) << margin_m;
      EXPECT_EQ(in_lanes.object, by_pairs.object);
      EXPECT_EQ(in_lanes.body_part, by_pairs.body_part);
      EXPECT_EQ(in_lanes.accuracy, by_pairs.accuracy);
      QueryOptions verdicts_only = options;
      verdicts_only.naming = Naming::kWhereTested;
      EXPECT_EQ(CheckCollisions(*world, body, states, verdicts_only)->verdict, by_pairs.verdict);
      EXPECT_GT(std::ranges::count(in_lanes.verdict, kFree), 200);
      EXPECT_GT(std::ranges::count(in_lanes.verdict, kHit), 200);
    }
  }
}

// The answer for a robot with an attached box equals the combined answers for its links and the
// box.
TEST(AttachedObjects, SayWhatLinksAndBoxSayByThemselves) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> angle(-3, 3), slide(-1, 1);
  SnapshotPtr world = RandomWorld(30, random, true);
  world = With(world, {Robot("arm"), Held("box"), Attach("box", RandomPose(random, 0.2))});
  std::vector<double> rows;
  for (int k = 0; k < 1000; ++k) rows.insert(rows.end(), {angle(random), slide(random)});
  const auto result = Check(*world, rows, {}, RobotScope::kWorld);
  QueryOptions no_robot;
  no_robot.ignore = {"arm", "box"};
  const WorldRobotPtr arm = world->FindRobot("arm");
  const QueryBody links = BodyFromRobot(*arm, RobotScope::kWorld);
  const QueryBody box = BodyFromObject(*world->Find("box"));
  int hits = 0;
  for (std::size_t k = 0; k < result.size(); ++k) {
    const JointRows row(
        arm->model(), arm->model().all,
        {.X_WB = arm->X_WB, .base = arm->state, .rows = std::span(rows).subspan(2 * k, 2)});
    std::vector<Pose> X_WL(3);
    row.Place(0, X_WL);
    const Pose X_WO = X_WL[2] * world->Find("box")->attachment->X_LO;
    const bool links_hit = CheckCollisions(*world, links, row, no_robot)->verdict[0] == kHit;
    const bool box_hits = CheckCollisions(*world, box, {&X_WO, 1}, no_robot)->verdict[0] == kHit;
    EXPECT_EQ(result[k] == kHit, links_hit || box_hits) << k;
    hits += box_hits && !links_hit ? 1 : 0;
  }
  EXPECT_GT(hits, 5) << "the box makes a difference";
}

}  // namespace
}  // namespace cwm::collision
