// Each test covers a defect of Bullet 3.24, through the engine that works around it.
#include <gtest/gtest.h>

#include "collision/engines/engine.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

const Engine& Bullet() { return GetEngine(EngineKind::kBullet); }

PairDistance Distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  const PlacedShape placed_a = Place(Bullet(), a, X_WA);
  const PlacedShape placed_b = Place(Bullet(), b, X_WB);
  return Bullet().Distance(placed_a.get(), placed_b.get(), 1e3);
}

const Pose kOrigin = Pose::Identity();

// The default margins would shorten the gap by 4 cm for each of the two shapes.
TEST(BulletProbe, NoShapeHasAMargin) {
  const Pose beside = MakeTranslation(1, 0, 0);
  const Convex hull{std::make_shared<const TriangleMesh>(BoxMesh({0.2, 0.2, 0.2}))};
  const Mesh mesh = MakeMesh(BoxMesh({0.2, 0.2, 0.2}));
  for (const Shape& shape : {Shape(Sphere{0.1}), Shape(Box{{0.2, 0.2, 0.2}}),
                             Shape(Cylinder{0.1, 0.2}), Shape(Capsule{0.1, 0.2}), Shape(hull)}) {
    EXPECT_NEAR(Distance(shape, kOrigin, Sphere{0.1}, beside).distance_m, 0.8, 1e-5);
    EXPECT_NEAR(Distance(shape, kOrigin, Box{{0.2, 0.2, 0.2}}, beside).distance_m, 0.8, 1e-5);
    EXPECT_NEAR(Distance(shape, kOrigin, mesh, beside).distance_m, 0.8, 1e-5);
  }
}

TEST(BulletProbe, ConcaveAgainstConcaveAnswersNothingAndIsNotInTheTable) {
  for (const QueryKind query : {QueryKind::kCollides, QueryKind::kDistance, QueryKind::kContacts}) {
    EXPECT_FALSE(Bullet().Supports(ShapeKind::kMesh, ShapeKind::kMesh, query));
    EXPECT_FALSE(Bullet().Supports(ShapeKind::kMesh, ShapeKind::kHalfSpace, query));
    EXPECT_FALSE(Bullet().Supports(ShapeKind::kHalfSpace, ShapeKind::kHalfSpace, query));
  }
}

TEST(BulletProbe, APrimitiveInsideAClosedMeshCollides) {
  const Mesh cube = MakeMesh(BoxMesh({1, 1, 1}));
  EXPECT_LT(Distance(Box{{0.1, 0.1, 0.1}}, kOrigin, cube, kOrigin).distance_m, 0);
}

// Without margins Bullet reports a gap of millimetres for some overlaps, which its own normal
// refutes.
TEST(BulletProbe, AnOverlapIsNeverCalledAGap) {
  std::mt19937 random(7);
  const Shape& plate = Catalogue()[8].shape;
  ASSERT_EQ(KindOf(plate), ShapeKind::kPlate);
  const Engine& exact = GetEngine(EngineKind::kExact);
  PlacedShape a = Place(exact, Box{{0.2, 0.12, 0.08}}, kOrigin);
  PlacedShape b = Place(exact, plate, kOrigin);
  PlacedShape bullet_a = Place(Bullet(), Box{{0.2, 0.12, 0.08}}, kOrigin);
  PlacedShape bullet_b = Place(Bullet(), plate, kOrigin);
  for (int i = 0; i < 1000; ++i) {
    bullet_a.X_WS = a.X_WS = RandomPose(random, 0.2);
    bullet_b.X_WS = b.X_WS = RandomPose(random, 0.2);
    const double truth_m = exact.Distance(a.get(), b.get(), 1e3).distance_m;
    if (std::abs(truth_m) < 1e-4) continue;
    EXPECT_EQ(Bullet().Distance(bullet_a.get(), bullet_b.get(), 1e3).distance_m < 0, truth_m < 0);
  }
}

TEST(BulletProbe, DepthIsLabelledAsItsBestEffort) {
  const PairDistance answer =
      Distance(Cylinder{0.05, 0.2}, kOrigin, Cylinder{0.05, 0.2}, MakeTranslation(0.08, 0, 0));
  EXPECT_LT(answer.distance_m, 0);
  EXPECT_EQ(answer.accuracy, Accuracy::kDegraded);
}

TEST(BulletProbe, DistanceToAHalfSpaceIsThatOfTheLowestPoint) {
  const PairDistance answer =
      Distance(HalfSpace{}, kOrigin, Capsule{0.1, 0.2}, MakeTranslation(0.3, 0.4, 0.5));
  EXPECT_NEAR(answer.distance_m, 0.3, 1e-12);
  EXPECT_NEAR(answer.normal.z(), 1, 1e-12);
  EXPECT_NEAR(answer.point_a.z(), 0, 1e-12);
  EXPECT_NEAR(answer.point_b.z(), 0.3, 1e-12);
}

}  // namespace
}  // namespace cwm::collision
