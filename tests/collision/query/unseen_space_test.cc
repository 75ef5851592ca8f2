// The treatment of unseen space in queries.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;

Change Unseen(const std::string& name, std::vector<Placed<>> shapes, const Pose& X_WO) {
  Change change = PutOf(name, std::move(shapes), X_WO);
  std::get<PutObject>(change.what).kind = ObjectKind::kUnseen;
  return change;
}

// A box of unseen space from x = 0.9 to 1.1, and a ball in it from 1.08 to 1.12.
std::shared_ptr<const WorldSnapshot> BallThatLooksOutOfUnseenSpace() {
  return WorldOf({Unseen("a_shadow", {{.shape = Box{{0.2, 1, 1}}}}, MakeTranslation(1, 0, 0)),
                  PutOf("ball", {{.shape = Sphere{0.02}}}, MakeTranslation(1.1, 0, 0))});
}

// Checks a small ball in free space, in the unseen box only, in both, and in the ball only.
CollisionColumns Check(UnseenSpace unseen) {
  const std::vector<Pose> poses = {MakeTranslation(0, 0, 0), MakeTranslation(0.95, 0, 0),
                                   MakeTranslation(1.09, 0, 0), MakeTranslation(1.125, 0, 0)};
  return *CheckCollisions(*BallThatLooksOutOfUnseenSpace(),
                          BodyFromShapes({{.shape = Sphere{0.01}}}), poses, {.unseen = unseen});
}

TEST(UnseenSpace, BlocksUnlessTheQuestionSaysOtherwise) {
  EXPECT_THAT(
      Check(QueryOptions().unseen).verdict,
      ElementsAre(Verdict::kFree, Verdict::kCollision, Verdict::kCollision, Verdict::kCollision));
}

TEST(UnseenSpace, IsNothingWhereItIsIgnored) {
  EXPECT_THAT(
      Check(UnseenSpace::kIgnore).verdict,
      ElementsAre(Verdict::kFree, Verdict::kFree, Verdict::kCollision, Verdict::kCollision));
}

TEST(UnseenSpace, IsADoubtWhereItIsReported) {
  const CollisionColumns columns = Check(UnseenSpace::kReport);
  EXPECT_THAT(columns.verdict, ElementsAre(Verdict::kFree, Verdict::kUndecided, Verdict::kCollision,
                                           Verdict::kCollision));
  EXPECT_EQ(columns.object[1], 0) << "the doubt has a name";
  EXPECT_EQ(columns.object[2], 1);
}

TEST(UnseenSpace, IsSeenByTheOtherQuestionsUnlessItIsIgnored) {
  const auto world = BallThatLooksOutOfUnseenSpace();
  const QueryBody body = BodyFromShapes({{.shape = Sphere{0.01}}});
  const std::vector<Pose> at_origin = {Pose::Identity()};
  const std::vector<RayRow> rays = {{.origin = {0, 0, 0}, .direction = {1, 0, 0}}};
  const std::vector<Vector3> points = {{0, 0, 0}};
  for (const UnseenSpace unseen :
       {UnseenSpace::kBlock, UnseenSpace::kReport, UnseenSpace::kIgnore}) {
    const double surface_m = unseen == UnseenSpace::kIgnore ? 1.08 : 0.9;
    const QueryOptions options = {.unseen = unseen};
    EXPECT_NEAR(GetDistances(*world, body, at_origin, options)->distance_m[0], surface_m - 0.01,
                1e-9);
    EXPECT_NEAR(CastRays(*world, rays, options)->distance_m[0], surface_m, 1e-9);
    EXPECT_NEAR(SamplePoints(*world, points, options)->distance_m[0], surface_m, 1e-9);
  }
}

}  // namespace
}  // namespace cwm::collision
