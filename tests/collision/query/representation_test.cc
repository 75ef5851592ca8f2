// The objects and parts that a query uses: of obstacles, of the body, and of its attached objects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/query/attached_objects.h"
#include "collision/query/world_filter.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using testing::Arm;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A ball at the object's origin, and a measured cube of 0.2 m centred at y = 1.
Change Hybrid(const std::string& name) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(),
                           .shape = Sphere{0.1},
                           .role = PartRole::kFitted,
                           .fit = std::nullopt});
  TriangleMesh cube = BoxMesh({0.2, 0.2, 0.2});
  for (Vector3& v : cube.vertices) v.y() += 1;
  model->surfaces.push_back({.surface = MakeMesh(cube), .point_count = 0});
  PutObject put;
  put.name = name;
  put.geometry = Prepare(model);
  return {.what = put, .expected_object_revision = {}};
}

Change Post(const std::string& name, double x_m, double y_m) {
  return PutOf(name, {{.shape = Box{{0.1, 0.1, 0.1}}}}, MakeTranslation(x_m, y_m, 0));
}

QueryOptions OptionsFor(Representation representation) {
  return {.representation = representation};
}

TEST(WorldFilter, CountsObjectsThatAreNeitherIgnoredNorAskingAndPartsOfTheRepresentation) {
  const auto ball = std::vector<Placed<>>{{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}};
  const auto world =
      WorldOf({PutOf("a", ball, Pose::Identity()), PutOf("b", ball, Pose::Identity()),
               PutOf("c", ball, Pose::Identity()), Hybrid("d")});
  QueryOptions options;
  options.ignore = {"b", "nobody"};
  options.representation = Representation::kSurfaces;
  QueryBody body;
  body.self = "c";
  const WorldFilter filter(*world, options, body);
  EXPECT_FALSE(filter.Skips(*world->Find("a")));
  EXPECT_TRUE(filter.Skips(*world->Find("b")));
  EXPECT_TRUE(filter.Skips(*world->Find("c")));
  EXPECT_TRUE(filter.SkipsPart(*world->Find("d"), 0));   // the ball
  EXPECT_FALSE(filter.SkipsPart(*world->Find("d"), 1));  // the measured cube
}

TEST(Representation, ChoosesThePartsOfTheObjectThatAsks) {
  const auto world = WorldOf({Hybrid("thing"), Post("post", 5, 0)});
  const QueryBody thing = BodyFromObject(*world->Find("thing"));
  // With its ball in the post, with its cube in it, and clear of it.
  const std::vector<Pose> poses = {MakeTranslation(5, 0, 0), MakeTranslation(5, -1, 0),
                                   MakeTranslation(5, 1, 0)};
  const auto verdicts = [&](Representation representation) {
    return CheckCollisions(*world, thing, PoseRows(poses), OptionsFor(representation))->verdict;
  };
  constexpr auto kHit = Verdict::kCollision, kFree = Verdict::kFree;
  // The post is a shape.
  EXPECT_THAT(verdicts(Representation::kHybrid), ElementsAre(kHit, kHit, kFree));
  EXPECT_THAT(verdicts(Representation::kShapes), ElementsAre(kHit, kFree, kFree));
  EXPECT_THAT(verdicts(Representation::kSurfaces), Each(kFree));
  const auto nearest =
      *GetDistances(*world, thing, PoseRows(poses), OptionsFor(Representation::kShapes));
  EXPECT_THAT(nearest.body_part, Each(0));
  EXPECT_NEAR(nearest.distance_m[1], 1 - 0.05 - 0.1, 1e-9);
}

TEST(Representation, MayLeaveNothingOfTheObjectThatAsks) {
  const auto world = WorldOf({Post("asks", 0, 0), Hybrid("thing")});
  const QueryBody post = BodyFromObject(*world->Find("asks"));
  const std::vector<Pose> poses = {MakeTranslation(0, 1, 0)};
  const QueryOptions options = OptionsFor(Representation::kSurfaces);
  EXPECT_THAT(CheckCollisions(*world, post, PoseRows(poses), options)->verdict,
              ElementsAre(Verdict::kFree));
  EXPECT_THAT(GetDistances(*world, post, PoseRows(poses), options)->distance_m, IsEmpty());
  EXPECT_THAT(GetContacts(*world, post, PoseRows(poses), options)->distance_m, IsEmpty());
}

TEST(Representation, LeavesShapesThatAskWhole) {
  const auto world = WorldOf({Hybrid("thing")});
  const QueryBody probe = BodyFromShapes({{.shape = Sphere{0.1}}});
  const std::vector<Pose> poses = {MakeTranslation(0, 1, 0)};
  EXPECT_THAT(CheckCollisions(*world, probe, PoseRows(poses), OptionsFor(Representation::kSurfaces))
                  ->verdict,
              ElementsAre(Verdict::kCollision));
}

TEST(Representation, ChoosesThePartsOfAttachedObjects) {
  Change attach{.what = AttachObject{.name = "thing",
                                     .robot = "arm",
                                     .link = "tip",
                                     .X_LO = Pose::Identity(),
                                     .touch_links = {}},
                .expected_object_revision = {}};
  Change arm{.what = testing::PutArm("arm", Arm()), .expected_object_revision = {}};
  // The post is at the cube. The tip is at the origin; its boxes are links and always count.
  const auto world = WorldOf({arm, Hybrid("thing"), attach, Post("post", 0, 1)});
  const WorldRobotPtr robot = world->FindRobot("arm");
  const QueryBody body = WithAttachedObjects(BodyFromRobot(*robot, RobotScope::kWorld), *world,
                                             *robot, RobotScope::kWorld);
  const JointGroup& all = robot->model().all;
  for (const std::size_t count : {1, 300}) {  // without and with the SIMD code
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) {
      values.insert(values.end(), robot->state.begin(), robot->state.end());
    }
    const JointRows rows(robot->model(), all,
                         {.X_WB = robot->X_WB, .base = robot->state, .rows = values});
    const auto verdicts = [&](Representation representation) {
      return CheckCollisions(*world, body, rows, OptionsFor(representation))->verdict;
    };
    EXPECT_THAT(verdicts(Representation::kHybrid), Each(Verdict::kCollision));
    EXPECT_THAT(verdicts(Representation::kShapes), Each(Verdict::kFree));
  }
}

}  // namespace
}  // namespace cwm::collision
