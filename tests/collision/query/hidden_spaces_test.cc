// Answers near space that no sensor saw, into which an object may extend.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "collision/motion/body_motion.h"
#include "collision/motion/check_motions.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

constexpr double kRadius_m = 0.01;

// A face from x = 0 to 0.005 that was seen from x < 0; behind it something may reach to x = 0.2.
std::shared_ptr<const PreparedModel> FaceWithHiddenDepth() {
  HybridModel model;
  model.shapes.push_back(
      {.X_OS = MakeTranslation(0.0025, 0, 0),
       .shape = Box{{0.005, 0.2, 0.2}},
       .role = PartRole::kCompleted,
       .hidden = Placed<Box>{.X_FS = MakeTranslation(0.1, 0, 0), .shape = {{0.2, 0.2, 0.2}}}});
  return Prepare(std::make_shared<const HybridModel>(std::move(model)));
}

Change PutFace(const Pose& X_WO = Pose::Identity()) {
  PutObject put;
  put.name = "face";
  put.X_WO = X_WO;
  put.geometry = FaceWithHiddenDepth();
  return {.what = std::move(put), .expected_object_revision = {}};
}

QueryBody Ball() { return BodyFromShapes({{.shape = Sphere{kRadius_m}}}); }

// In front of the face, on it, behind it in what is hidden, and behind that.
std::vector<Pose> PosesAlongX() {
  return {MakeTranslation(-0.05, 0, 0), MakeTranslation(0.0, 0, 0), MakeTranslation(0.1, 0, 0),
          MakeTranslation(0.3, 0, 0)};
}

TEST(HiddenSpaces, AreFreeWithABound) {
  const auto columns = *CheckCollisions(*WorldOf({PutFace()}), Ball(), PosesAlongX(), {});
  EXPECT_THAT(columns.verdict,
              ElementsAre(Verdict::kFree, Verdict::kCollision, Verdict::kFree, Verdict::kFree));
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kExact, Accuracy::kExact, Accuracy::kBounded,
                                            Accuracy::kExact));
}

TEST(HiddenSpaces, MoveAndGoWithTheirObject) {
  const auto world = WorldOf({PutFace()});
  const std::vector<Change> move = {
      {.what = MoveObject{.name = "face", .X_WO = MakeTranslation(0.2, 0, 0)},
       .expected_object_revision = {}}};
  const auto moved = *Apply(world, move);
  EXPECT_THAT(
      CheckCollisions(*moved, Ball(), PosesAlongX(), {})->accuracy,
      ElementsAre(Accuracy::kExact, Accuracy::kExact, Accuracy::kExact, Accuracy::kBounded));
  const std::vector<Change> removal = {
      {.what = RemoveObject{.name = "face"}, .expected_object_revision = {}}};
  const auto gone = *Apply(world, removal);
  EXPECT_THAT(CheckCollisions(*gone, Ball(), PosesAlongX(), {})->accuracy, Each(Accuracy::kExact));
}

TEST(HiddenSpaces, BoundDistances) {
  const auto columns = *GetDistances(*WorldOf({PutFace()}), Ball(), PosesAlongX(), {});
  ASSERT_EQ(columns.distance_m.size(), 4u);
  EXPECT_EQ(columns.accuracy[0], Accuracy::kExact);
  EXPECT_NEAR(columns.distance_m[2], 0.1 - 0.005 - kRadius_m, 1e-9);
  EXPECT_EQ(columns.accuracy[2], Accuracy::kBounded);
  // The body could fill the hidden box: the ball would be 0.1 m from its sides.
  EXPECT_GE(columns.bound_m[2], columns.distance_m[2] + 0.1 + kRadius_m - 1e-9);
  EXPECT_NEAR(columns.distance_m[3], 0.3 - 0.005 - kRadius_m, 1e-9);
  EXPECT_EQ(columns.accuracy[3], Accuracy::kBounded);
  const double to_hidden_m = 0.3 - 0.2 - kRadius_m;
  EXPECT_GE(columns.bound_m[3], columns.distance_m[3] - to_hidden_m - 1e-9);
  EXPECT_LE(columns.bound_m[3], columns.distance_m[3] - to_hidden_m + 0.01);
}

TEST(HiddenSpaces, BoundTheNearestAnswerThatNamesAnotherObject) {
  const auto world =
      WorldOf({PutFace(), PutOf("ball", {{.shape = Sphere{0.01}}}, MakeTranslation(0.35, 0, 0))});
  const std::vector<Pose> at = {MakeTranslation(0.25, 0, 0)};
  const auto columns = *GetDistances(*world, Ball(), at, {});
  EXPECT_NEAR(columns.distance_m.at(0), 0.08, 1e-9);
  EXPECT_EQ(columns.accuracy.at(0), Accuracy::kBounded) << "what is hidden is 0.04 m away";
  EXPECT_NEAR(columns.bound_m.at(0), 0.08 - 0.04, 0.01);
}

TEST(HiddenSpaces, BoundPointsByTheDistanceOfTheSpace) {
  const std::vector<Vector3> points = {{-0.05, 0, 0}, {0.002, 0, 0}, {0.05, 0, 0}, {0.3, 0, 0}};
  const auto columns = *SamplePoints(*WorldOf({PutFace()}), points, {});
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kExact, Accuracy::kBounded,
                                            Accuracy::kBounded, Accuracy::kBounded));
  ASSERT_EQ(columns.bounds.size(), 3u);
  EXPECT_EQ(columns.bounds[1].row, 2u);
  EXPECT_NEAR(columns.bounds[1].bound_m, 0.045 + 0.05, 1e-9);
  EXPECT_NEAR(columns.bounds[2].bound_m, 0.295 - 0.1, 1e-9);
}

TEST(HiddenSpaces, MakeRaysThatPassThemUncertain) {
  const std::vector<RayRow> rays = {
      {.origin = {-1, 0, 0}, .direction = {1, 0, 0}},                           // to the face
      {.origin = {1, 0, 0}, .direction = {-1, 0, 0}},                           // from behind
      {.origin = {0.1, -1, 0}, .direction = {0, 1, 0}},                         // through
      {.origin = {0.1, -1, 0}, .direction = {0, 1, 0}, .max_distance_m = 0.5},  // ends before
      {.origin = {0.1, -1, 0.15}, .direction = {0, 1, 0}}};                     // above
  const auto columns = *CastRays(*WorldOf({PutFace()}), rays, {});
  EXPECT_THAT(columns.hit, ElementsAre(1, 1, 0, 0, 0));
  EXPECT_THAT(columns.accuracy,
              ElementsAre(Accuracy::kExact, Accuracy::kBounded, Accuracy::kBounded,
                          Accuracy::kExact, Accuracy::kExact));
}

TEST(HiddenSpaces, MakeMotionsThroughThemUncertain) {
  const auto world = WorldOf({PutFace()});
  const QueryBody body = Ball();
  std::vector<std::unique_ptr<BodyMotion>> edges;
  for (const double x_m : {0.1, -0.3}) {
    edges.push_back(std::make_unique<RigidMotion>(body, MakeTranslation(x_m, -0.2, 0),
                                                  MakeTranslation(x_m, 0.2, 0)));
  }
  const MotionColumns columns = *CheckMotions(*world, body, edges, {});
  EXPECT_THAT(columns.verdict, Each(MotionVerdict::kFree));
  EXPECT_EQ(columns.accuracy[0], Accuracy::kBounded);
}

TEST(HiddenSpaces, CountOnlyForPairsThatAreTested) {
  const auto world = WorldOf({PutFace()});
  QueryOptions options;
  options.ignore = {"face"};
  EXPECT_THAT(CheckCollisions(*world, Ball(), PosesAlongX(), options)->accuracy,
              Each(Accuracy::kExact));
}

TEST(HiddenSpaces, OfTheQueryingObjectBoundItsAnswers) {
  const auto world =
      WorldOf({PutFace(), PutOf("ball", {{.shape = Sphere{0.01}}}, MakeTranslation(-0.5, 0, 0))});
  const QueryBody face = BodyFromObject(*world->Find("face"));
  const std::vector<Pose> at = {Pose::Identity()};
  EXPECT_THAT(CheckCollisions(*world, face, at, {})->accuracy, ElementsAre(Accuracy::kBounded));
  const auto columns = *GetDistances(*world, face, at, {});
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kBounded));
  EXPECT_NEAR(columns.bound_m.at(0), 0.195, 1e-9);
}

}  // namespace
}  // namespace cwm::collision
