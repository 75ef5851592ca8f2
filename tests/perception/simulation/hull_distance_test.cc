#include "perception/simulation/hull_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kPromised_m = 1e-6;  // as hull_distance.h promises

Vector3 RandomPoint(RandomDraws& draws, double reach_m) {
  const double x = draws.Uniform(-reach_m, reach_m);
  const double y = draws.Uniform(-reach_m, reach_m);
  return {x, y, draws.Uniform(-reach_m, reach_m)};
}

Pose RandomPose(RandomDraws& draws, double reach_m) {
  const Vector3 translation_m = RandomPoint(draws, reach_m);
  const double w = draws.Normal();
  const double x = draws.Normal();
  const double y = draws.Normal();
  return MakePose(translation_m, Quaternion(w, x, y, draws.Normal()).normalized());
}

std::vector<Shape> ConvexShapes() {
  return {Sphere{.radius_m = 0.05},
          Box{.size_m = {0.08, 0.12, 0.2}},
          Cylinder{.radius_m = 0.04, .length_m = 0.15},
          Cone{.radius_bottom_m = 0.03, .radius_top_m = 0.05, .length_m = 0.1},
          Cone{.radius_bottom_m = 0.05, .radius_top_m = 0, .length_m = 0.1},
          Capsule{.radius_m = 0.02, .length_m = 0.1},
          Plate{.outline = {{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.2}, {-0.1, 0.2}},
                .holes = {},
                .thickness_m = 0.02}};
}

// The distance of a ball from a shape is that of its centre less its radius.
TEST(HullDistance, OfABallIsTheSignedDistanceOfItsCentre) {
  RandomDraws draws(1, 0);
  for (const Shape& shape : ConvexShapes()) {
    for (int i = 0; i < 300; ++i) {
      const Placed<> placed{.X_FS = RandomPose(draws, 0.1), .shape = shape};
      const double radius_m = draws.Uniform(0.001, 0.05);
      const Vector3 center = RandomPoint(draws, 0.4);
      const Placed<> ball{.X_FS = Pose(Eigen::Translation3d(center)),
                          .shape = Sphere{.radius_m = radius_m}};
      const double expected_m =
          std::max(0.0, SignedDistance_m(shape, placed.X_FS.inverse() * center) - radius_m);
      for (const double found_m : {HullDistance_m(placed, ball), HullDistance_m(ball, placed)}) {
        EXPECT_LE(found_m, expected_m + 1e-12);
        EXPECT_GE(found_m, expected_m - 2 * kPromised_m);
      }
    }
  }
}

// The distance is at most that of any vertex of one shape's mesh from the other shape.
TEST(HullDistance, IsTheLeastOverTheSurfaceOfTheOther) {
  constexpr double kMesh_m = 2e-4;  // deviation of the inscribed meshes
  RandomDraws draws(2, 0);
  const std::vector<Shape> shapes = ConvexShapes();
  for (const Shape& shape_a : shapes) {
    for (const Shape& shape_b : shapes) {
      const Placed<> a{.X_FS = RandomPose(draws, 0.3), .shape = shape_a};
      const Placed<> b{.X_FS = RandomPose(draws, 0.3), .shape = shape_b};
      const TriangleMesh mesh = Tessellate(shape_a, kMesh_m);
      const Pose X_BA = b.X_FS.inverse() * a.X_FS;
      double min_m = 1;
      for (const Vector3& vertex : mesh.vertices) {
        min_m = std::min(min_m, SignedDistance_m(shape_b, X_BA * vertex));
      }
      const double found_m = HullDistance_m(a, b);
      EXPECT_LE(found_m, std::max(0.0, min_m) + 1e-9);
      // The distance is symmetric.
      EXPECT_NEAR(found_m, HullDistance_m(b, a), 2 * kPromised_m);
      if (min_m <= 0) {
        EXPECT_EQ(found_m, 0);
      }
    }
  }
}

TEST(HullDistance, OfBoxesFaceToFaceIsTheirGap) {
  const Placed<> a{.shape = Box{.size_m = {0.1, 0.2, 0.3}}};
  for (const double gap_m : {0.0001, 0.01, 0.5}) {
    const Placed<> b{.X_FS = MakeTranslation(0.1 + gap_m, 0.03, -0.02),
                     .shape = Box{.size_m = {0.1, 0.1, 0.1}}};
    EXPECT_NEAR(HullDistance_m(a, b), gap_m, kPromised_m);
  }
}

TEST(SlideUntilTouching, StopsBeforeTheObstacle) {
  const SimulatedObject box{.name = "box", .parts = {{.shape = Box{.size_m = {0.1, 0.1, 0.1}}}}};
  SimulatedObject can{.name = "can",
                      .parts = {{.shape = Cylinder{.radius_m = 0.03, .length_m = 0.1}}}};
  can.X_WO = MakeTranslation(0.4, 0.02, 0);
  ASSERT_TRUE(SlideUntilTouching(-Vector3::UnitX(), box, can));
  EXPECT_GT(can.X_WO.translation().x(), 0.05 + 0.03);
  EXPECT_LT(can.X_WO.translation().x(), 0.05 + 0.03 + 1e-4);
  EXPECT_EQ(can.X_WO.translation().y(), 0.02);
}

TEST(SlideUntilTouching, LeavesAnObjectThatMissesWhereItIs) {
  const SimulatedObject box{.name = "box", .parts = {{.shape = Box{.size_m = {0.1, 0.1, 0.1}}}}};
  SimulatedObject ball{.name = "ball", .parts = {{.shape = Sphere{.radius_m = 0.03}}}};
  ball.X_WO = MakeTranslation(0.4, 0.2, 0);
  EXPECT_FALSE(SlideUntilTouching(-Vector3::UnitX(), box, ball));
  EXPECT_EQ(ball.X_WO.translation(), Vector3(0.4, 0.2, 0));
}

}  // namespace
}  // namespace cwm::perception
