// Answers about a mesh with a closed hole say where they depend on what closes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "collision/geometry/mesh_closing.h"
#include "collision/motion/body_motion.h"
#include "collision/motion/check_motions.h"
#include "collision/query/get_world_contacts.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

constexpr double kRadius_m = 0.01;
constexpr double kWidth_m = 0.01;  // of the hole

// A cube of 1 m. The triangle between the edge of its top at y = -0.5 and a point on the side at
// x = 0.5 is missing.
Shape CubeWithHole() {
  TriangleMesh mesh;
  for (const double z : {-0.5, 0.5}) {
    mesh.vertices.insert(mesh.vertices.end(),
                         {{-0.5, -0.5, z}, {0.5, -0.5, z}, {0.5, 0.5, z}, {-0.5, 0.5, z}});
  }
  mesh.vertices.emplace_back(0.5, -0.5 + kWidth_m, 0.5);
  mesh.triangles = {{0, 3, 2}, {0, 2, 1}, {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 8}, {1, 8, 5},
                    {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}, {4, 8, 6}, {4, 6, 7}};
  const auto solid = SolidOf(std::make_shared<const TriangleMesh>(std::move(mesh)));
  EXPECT_TRUE(solid->watertight);
  EXPECT_EQ(solid->caps->size(), 1u);
  EXPECT_NEAR(solid->caps->front().bound_m(), kWidth_m, 1e-6);
  return *solid;
}

// The cube is tilted about its x axis, so that its box in the world tells little about it.
const Pose kTilted(Eigen::AngleAxisd(0.5, Vector3::UnitX()));

// A pose with this origin in the frame of the cube.
Pose AtCube(double x_m, double y_m, double z_m) { return kTilted * MakeTranslation(x_m, y_m, z_m); }

Change PutCube() { return PutOf("cube", {{.shape = CubeWithHole()}}, kTilted); }
QueryBody Ball() { return BodyFromShapes({{.shape = Sphere{kRadius_m}}}); }

TEST(CappedMesh, IsASolidAndSaysWhereItsHoleMatters) {
  const std::vector<Pose> at = {AtCube(0, 0, 0), AtCube(0, -0.498, 0.5), AtCube(0, 0, 0.52),
                                AtCube(0, -0.497, 0.512), AtCube(0, -0.6, 0.4)};
  const auto columns = *CheckCollisions(*WorldOf({PutCube()}), Ball(), at, {});
  EXPECT_THAT(columns.verdict, ElementsAre(Verdict::kCollision, Verdict::kCollision, Verdict::kFree,
                                           Verdict::kFree, Verdict::kFree));
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kExact, Accuracy::kBounded, Accuracy::kExact,
                                            Accuracy::kBounded, Accuracy::kExact));
  const auto far = *CheckCollisions(*WorldOf({PutCube()}), Ball(), at, {.margin_m = 0.2});
  EXPECT_EQ(far.verdict[4], Verdict::kCollision);
  EXPECT_EQ(far.accuracy[4], Accuracy::kBounded) << "the hole is nearer than the margin";
}

TEST(CappedMesh, OfTheQueryingObjectBoundsItsAnswers) {
  const auto world =
      WorldOf({PutCube(), PutOf("ball", {{.shape = Sphere{kRadius_m}}}, AtCube(0, -0.497, 0.512))});
  const QueryBody cube = BodyFromObject(*world->Find("cube"));
  const std::vector<Pose> at = {kTilted, AtCube(0, 0, -0.3)};
  const auto columns = *CheckCollisions(*world, cube, at, {});
  EXPECT_THAT(columns.verdict, Each(Verdict::kFree));
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kBounded, Accuracy::kExact));
}

TEST(CappedMesh, BoundsDistances) {
  const std::vector<Pose> at = {AtCube(0, -0.495, 0.55), AtCube(0, 0.4, 0.55)};
  const auto columns = *GetDistances(*WorldOf({PutCube()}), Ball(), at, {});
  EXPECT_NEAR(columns.distance_m[0], 0.04, 1e-9);
  EXPECT_NEAR(columns.distance_m[1], 0.04, 1e-9);
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kBounded, Accuracy::kExact));
  EXPECT_NEAR(columns.bound_m[0], kWidth_m, 1e-6);
  EXPECT_EQ(columns.bound_m[1], 0);
}

TEST(CappedMesh, BoundsTheNearestAnswerThatNamesAnotherObject) {
  const std::vector<Pose> at = {AtCube(0, -0.495, 0.55)};
  // The hole's capsule is 0.035 m away from the ball at z = 0.55.
  for (const double gap_m : {0.038, 0.030}) {
    const auto world = WorldOf(
        {PutCube(), PutOf("other", {{.shape = Sphere{0.01}}}, AtCube(0, -0.495, 0.57 + gap_m))});
    const auto columns = *GetDistances(*world, Ball(), at, {});
    EXPECT_NEAR(columns.distance_m[0], gap_m, 1e-9);
    EXPECT_EQ(columns.accuracy[0], gap_m > 0.035 ? Accuracy::kBounded : Accuracy::kExact);
  }
}

TEST(CappedMesh, BoundsContactsAndContactsOfTheWorld) {
  const std::vector<Pose> at = {AtCube(0, -0.497, 0.505), AtCube(0, 0, 0.505)};
  const auto columns = *GetContacts(*WorldOf({PutCube()}), Ball(), at, {});
  ASSERT_EQ(columns.row_begin[1], 1u);
  EXPECT_EQ(columns.accuracy[0], Accuracy::kBounded);
  EXPECT_GE(columns.bound_m[0], kWidth_m + 0.005 - 1e-6) << "the overlap may be a gap";
  for (const double y_m : {-0.497, 0.0}) {
    const auto world =
        WorldOf({PutCube(), PutOf("ball", {{.shape = Sphere{kRadius_m}}}, AtCube(0, y_m, 0.505))});
    const auto contacts = *GetWorldContacts(*world, {});
    ASSERT_EQ(contacts.distance_m.size(), 1u);
    EXPECT_EQ(contacts.bound_m[0] >= kWidth_m, y_m < -0.4);
  }
}

TEST(CappedMesh, BoundsPoints) {
  std::vector<Vector3> points = {{0, 0, 0}, {0, -0.49, 0.49}, {0, -0.495, 0.53}, {0, 0, 0.7}};
  for (Vector3& p : points) p = kTilted * p;
  const auto columns = *SamplePoints(*WorldOf({PutCube()}), points, {});
  EXPECT_NEAR(columns.distance_m[0], -0.5, 1e-9);
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kExact, Accuracy::kBounded,
                                            Accuracy::kBounded, Accuracy::kExact));
  ASSERT_EQ(columns.bounds.size(), 2u);
  EXPECT_NEAR(columns.bounds[0].bound_m, kWidth_m + 0.01, 1e-6) << "it may be outside";
  EXPECT_NEAR(columns.bounds[1].bound_m, kWidth_m, 1e-6);
}

TEST(CappedMesh, MakesRaysThroughItsHoleUncertain) {
  std::vector<RayRow> rays = {{.origin = {0.4, -0.495, 1}, .direction = {0, 0, -1}},
                              {.origin = {0, 0.2, 1}, .direction = {0, 0, -1}},
                              {.origin = {0.4, -0.495, 0}, .direction = {0, 0, 1}},
                              {.origin = {0, 0.2, 0}, .direction = {0, 0, 1}}};
  for (RayRow& ray : rays) {
    ray.origin = kTilted * ray.origin;
    ray.direction = kTilted.linear() * ray.direction;
  }
  const auto columns = *CastRays(*WorldOf({PutCube()}), rays, {});
  EXPECT_THAT(columns.hit, Each(1));
  EXPECT_THAT(columns.accuracy, ElementsAre(Accuracy::kBounded, Accuracy::kExact,
                                            Accuracy::kBounded, Accuracy::kExact));
}

TEST(CappedMesh, LabelsMotionsThatPassItsHole) {
  const auto world = WorldOf({PutCube()});
  const QueryBody body = Ball();
  std::vector<std::unique_ptr<BodyMotion>> edges;
  const auto add = [&](const Vector3& from, const Vector3& to) {
    edges.push_back(std::make_unique<RigidMotion>(body, AtCube(from.x(), from.y(), from.z()),
                                                  AtCube(to.x(), to.y(), to.z())));
  };
  add({0, -0.51, 0.52}, {0.1, -0.51, 0.52});  // beside the hole
  add({0, 0.4, 0.52}, {0.1, 0.4, 0.52});      // far from it
  add({0, 0, 0.8}, {0, 0, 0.2});              // into the top
  const MotionColumns columns = *CheckMotions(*world, body, edges, {});
  EXPECT_THAT(columns.verdict,
              ElementsAre(MotionVerdict::kFree, MotionVerdict::kFree, MotionVerdict::kContact));
  EXPECT_THAT(columns.accuracy,
              ElementsAre(Accuracy::kBounded, Accuracy::kExact, Accuracy::kExact));
}

}  // namespace
}  // namespace cwm::collision
