// Each test covers a defect of FCL 0.7.0, through the engine that works around it.
#include <gtest/gtest.h>

#include <numbers>

#include "collision/engines/engine.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

const Engine& Fcl() { return GetEngine(EngineKind::kFcl); }

PairDistance Distance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  const PlacedShape placed_a = Place(Fcl(), a, X_WA);
  const PlacedShape placed_b = Place(Fcl(), b, X_WB);
  return Fcl().Distance(placed_a.get(), placed_b.get(), 1e3);
}

bool Collides(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  const PlacedShape placed_a = Place(Fcl(), a, X_WA);
  const PlacedShape placed_b = Place(Fcl(), b, X_WB);
  return Fcl().Collides(placed_a.get(), placed_b.get());
}

const Pose kOrigin = Pose::Identity();

// FCL's distance() would crash.
TEST(FclProbe, DistanceToAHalfSpaceIsThatOfTheKernels) {
  std::mt19937 random(8);
  for (const CatalogueShape& entry : Catalogue()) {
    for (int i = 0; i < 20; ++i) {
      const Pose X_WS = RandomPose(random, 0.3), X_WH = RandomPose(random, 0.1);
      for (const bool is_first : {false, true}) {
        const auto ask = [&](const Engine& engine) {
          const PlacedShape shape = Place(engine, entry.shape, X_WS);
          const PlacedShape floor = Place(engine, HalfSpace{}, X_WH);
          return is_first ? engine.Distance(shape.get(), floor.get(), 1e3)
                          : engine.Distance(floor.get(), shape.get(), 1e3);
        };
        const PairDistance result = ask(Fcl()), truth = ask(GetEngine(EngineKind::kExact));
        EXPECT_NEAR(result.distance_m, truth.distance_m, 1e-12) << entry.name;
        EXPECT_EQ(result.accuracy, truth.accuracy) << entry.name;
        EXPECT_EQ(result.solver, Solver::kKernels) << entry.name;
      }
    }
  }
}

// The number of wrong answers of FCL when B is moved along the pair's normal to several distances.
int WrongYesAndNo(const Shape& a, const Shape& b, std::initializer_list<double> distances_m) {
  const Engine& exact = GetEngine(EngineKind::kExact);
  const Pose X_WA = Pose::Identity();
  const PlacedShape placed_a = Place(exact, a, X_WA);
  std::mt19937 random(3);
  int wrong = 0;
  for (int i = 0; i < 100; ++i) {
    Pose X_WB = RandomPose(random, 0.5);
    const PairDistance apart = exact.Distance(placed_a.get(), Place(exact, b, X_WB).get(), 1e3);
    if (apart.distance_m < 0 || apart.accuracy != Accuracy::kExact) continue;
    const Vector3 from = X_WB.translation();
    for (const double distance_m : distances_m) {
      X_WB.translation() = from - (apart.distance_m - distance_m) * apart.normal;
      wrong += Collides(a, X_WA, b, X_WB) != (distance_m < 0) ? 1 : 0;
    }
  }
  return wrong;
}

TEST(FclProbe, YesAndNoAreExactWhereFclHasAFormula) {
  int pairs = 0;
  for (const CatalogueShape& a : Catalogue()) {
    for (const CatalogueShape& b : Catalogue()) {
      if (Fcl().CollisionAccuracy(KindOf(a.shape), KindOf(b.shape)) != Accuracy::kExact) continue;
      ++pairs;
      EXPECT_EQ(WrongYesAndNo(a.shape, b.shape, {-1e-3, -1e-7, 1e-7, 1e-3}), 0)
          << a.name << " " << b.name;
    }
  }
  EXPECT_GT(pairs, 20);
}

// GJK reports a gap for overlaps smaller than its tolerance, and sometimes for one of a millimetre.
TEST(FclProbe, YesAndNoOfASearchAreABestEffort) {
  const Shape box = Box{{0.2, 0.12, 0.08}}, cylinder = Cylinder{0.05, 0.2},
              cone = Cone{0.08, 0, 0.2};
  EXPECT_EQ(Fcl().CollisionAccuracy(ShapeKind::kBox, ShapeKind::kCylinder), Accuracy::kDegraded);
  EXPECT_EQ(Fcl().CollisionAccuracy(ShapeKind::kCylinder, ShapeKind::kBox), Accuracy::kDegraded);
  EXPECT_GT(WrongYesAndNo(box, cylinder, {-1e-7}), 0);
  EXPECT_EQ(Fcl().CollisionAccuracy(ShapeKind::kCone, ShapeKind::kCone), Accuracy::kDegraded);
  EXPECT_GT(WrongYesAndNo(cone, cone, {-1e-3}), 0);
}

TEST(FclProbe, AConvexHullAgainstAHalfSpaceIsYesOrNoWithoutACrash) {
  const Convex hull{std::make_shared<const TriangleMesh>(BoxMesh({0.2, 0.2, 0.2}))};
  EXPECT_TRUE(Collides(hull, MakeTranslation(0, 0, 0.099), HalfSpace{}, kOrigin));
  EXPECT_FALSE(Collides(hull, MakeTranslation(0, 0, 0.101), HalfSpace{}, kOrigin));
  EXPECT_TRUE(Collides(hull, MakeTranslation(5, 7, -3), HalfSpace{}, kOrigin));  // deep below
}

// FCL's collide() misses some cones that lie apex down, and objects inside a closed mesh.
TEST(FclProbe, ConesAndMeshesAgainstAHalfSpaceAreNotAskedOfFcl) {
  const Pose apex_down(Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()));
  const Cone cone{0.1, 0, 0.2};
  EXPECT_TRUE(Collides(cone, MakeTranslation(0, 0, 0.0999) * apex_down, HalfSpace{}, kOrigin));
  EXPECT_FALSE(Collides(cone, MakeTranslation(0, 0, 0.1001) * apex_down, HalfSpace{}, kOrigin));
  const Mesh cube = MakeMesh(BoxMesh({0.2, 0.2, 0.2}));
  EXPECT_TRUE(Collides(cube, MakeTranslation(0, 0, -5), HalfSpace{}, kOrigin));
  EXPECT_FALSE(Collides(HalfSpace{}, kOrigin, cube, MakeTranslation(0, 0, 0.101)));
  EXPECT_FALSE(Collides(HalfSpace{}, kOrigin, HalfSpace{}, MakeTranslation(0, 0, 1) * apex_down));
}

TEST(FclProbe, TwoSpheresThatOverlapHaveTheDepthOfTheirOverlap) {
  const PairDistance answer =
      Distance(Sphere{0.05}, kOrigin, Sphere{0.05}, MakeTranslation(0.098, 0, 0));
  EXPECT_NEAR(answer.distance_m, -0.002, 1e-12);  // FCL: -1 unsigned, -0.001999991 signed
  EXPECT_NEAR(answer.normal.x(), 1, 1e-12);
}

TEST(FclProbe, TwoOverlappingCubeMeshesPenetrateAndSayThatTheDepthIsABound) {
  const Mesh cube = MakeMesh(BoxMesh({1, 1, 1}));
  const PairDistance answer = Distance(cube, kOrigin, cube, MakeTranslation(0.5, 0.1, 0.05));
  EXPECT_LT(answer.distance_m, 0);  // FCL: 0
  EXPECT_EQ(answer.accuracy, Accuracy::kBounded);
  EXPECT_LE(std::abs(answer.distance_m + 0.5), answer.bound_m + 1e-9);
  EXPECT_TRUE(Collides(cube, kOrigin, cube, MakeTranslation(0.5, 0.1, 0.05)));
}

TEST(FclProbe, ASmallMeshInsideALargeOneCollides) {
  const Mesh small = MakeMesh(BoxMesh({0.1, 0.1, 0.1}));
  const Mesh large = MakeMesh(BoxMesh({1, 1, 1}));
  const Pose inside = MakeTranslation(0.1, -0.2, 0.05);
  EXPECT_TRUE(Collides(small, inside, large, kOrigin));
  EXPECT_TRUE(Collides(large, kOrigin, small, inside));
  EXPECT_LT(Distance(small, inside, large, kOrigin).distance_m, 0);
  EXPECT_FALSE(Collides(small, MakeTranslation(0.7, 0, 0), large, kOrigin));
}

TEST(FclProbe, APrimitiveInsideAClosedMeshCollidesAndAMeshInsideAPrimitiveToo) {
  const Mesh cube = MakeMesh(BoxMesh({1, 1, 1}));
  EXPECT_TRUE(Collides(Sphere{0.1}, kOrigin, cube, kOrigin));
  EXPECT_TRUE(Collides(cube, kOrigin, Sphere{5}, kOrigin));
  EXPECT_LT(Distance(Cylinder{0.1, 0.1}, kOrigin, cube, kOrigin).distance_m, 0);
}

TEST(FclProbe, AnOpenMeshHasNoInside) {
  TriangleMesh lidless = BoxMesh({1, 1, 1});
  lidless.triangles.pop_back();
  const Mesh open = MakeMesh(std::move(lidless));
  ASSERT_FALSE(open.watertight);
  EXPECT_FALSE(Collides(Sphere{0.1}, kOrigin, open, kOrigin));
  const PairDistance answer = Distance(Sphere{0.1}, kOrigin, open, kOrigin);
  EXPECT_NEAR(answer.distance_m, 0.4, 1e-4);
  EXPECT_EQ(answer.accuracy, Accuracy::kSurfaceOnly);
}

// FCL's collide() measures depth along the ray between centres: 2 mm wrong for cylinders that
// overlap by 2 mm.
TEST(FclProbe, CrossedCylindersHaveTheLeastDepth) {
  const Pose lying = MakePose(
      {0.02, 0.098, 0.03}, Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX())) *
                               Quaternion(Eigen::AngleAxisd(0.5, Vector3::UnitY())));
  const PairDistance fcl = Distance(Cylinder{0.05, 0.4}, kOrigin, Cylinder{0.05, 0.1}, lying);
  const Engine& exact = GetEngine(EngineKind::kExact);
  const PlacedShape a = Place(exact, Cylinder{0.05, 0.4}, kOrigin);
  const PlacedShape b = Place(exact, Cylinder{0.05, 0.1}, lying);
  EXPECT_LT(fcl.distance_m, 0);
  EXPECT_NEAR(fcl.distance_m, exact.Distance(a.get(), b.get(), 1e3).distance_m, 1e-9);
}

// FCL's signed distance fails an assertion, which ends the process, for some overlaps of rotated
// boxes and hulls.
TEST(FclProbe, DeepAndTouchingOverlapsAreAnsweredWithoutAnAssertion) {
  std::mt19937 random(4);
  for (const CatalogueShape& a : Catalogue()) {
    for (const CatalogueShape& b : Catalogue()) {
      if (!Fcl().Supports(KindOf(a.shape), KindOf(b.shape), QueryKind::kDistance)) continue;
      for (int i = 0; i < 20; ++i) {
        const Pose X_WA = RandomPose(random, 0.01);
        EXPECT_LE(Distance(a.shape, X_WA, b.shape, RandomPose(random, 0.01)).distance_m, 0.2);
        EXPECT_LE(Distance(a.shape, X_WA, b.shape, X_WA).distance_m, 0.2);  // concentric
      }
    }
  }
}

// FCL returns the witness on the mesh first, and those of a sphere in the frames of their own
// shapes.
TEST(FclProbe, WitnessesOnAMeshBelongToTheMesh) {
  const Mesh cube = MakeMesh(BoxMesh({1, 1, 1}));
  const Pose X_WM = MakeTranslation(3, 0, 0);
  for (const Shape& shape : {Shape(Sphere{0.25}), Shape(Capsule{0.25, 0.1})}) {
    const PairDistance answer = Distance(shape, kOrigin, cube, X_WM);
    EXPECT_NEAR(answer.point_a.x(), 0.25, 1e-6);
    EXPECT_NEAR(answer.point_b.x(), 2.5, 1e-6);
    EXPECT_NEAR(answer.normal.x(), 1, 1e-6);
    EXPECT_NEAR(Distance(cube, X_WM, shape, kOrigin).point_a.x(), 2.5, 1e-6);
  }
}

// GJK stops 14 mm too far if a box squarely faces a triangle of a mesh.
TEST(FclProbe, ABoxThatFacesAMeshIsLabelledAsBestEffort) {
  const Mesh cube = MakeMesh(BoxMesh({1, 1, 1}));
  const PairDistance answer =
      Distance(Box{{0.5, 0.5, 0.5}}, kOrigin, cube, MakeTranslation(3, 0, 0));
  EXPECT_EQ(answer.accuracy, Accuracy::kDegraded);
  EXPECT_GE(answer.distance_m, 2.25 - 1e-9);  // witnesses are real points: never too near
}

// If GJK stops early between convex shapes, the bound of the answer grows by as much.
TEST(FclProbe, AnEarlyStopBetweenConvexShapesIsWithinTheBoundStated) {
  std::mt19937 random(7);
  const Engine& exact = GetEngine(EngineKind::kExact);
  PlacedShape fcl_a = Place(Fcl(), Cone{0, 0.08, 0.2}, kOrigin);
  PlacedShape fcl_b = Place(Fcl(), Cylinder{0.05, 0.2}, kOrigin);
  PlacedShape a = Place(exact, Cone{0, 0.08, 0.2}, kOrigin);
  PlacedShape b = Place(exact, Cylinder{0.05, 0.2}, kOrigin);
  for (int i = 0; i < 3000; ++i) {
    fcl_a.X_WS = a.X_WS = RandomPose(random, 0.15);
    fcl_b.X_WS = b.X_WS = RandomPose(random, 0.15);
    const PairDistance answer = Fcl().Distance(fcl_a.get(), fcl_b.get(), 1e3);
    const double truth_m = exact.Distance(a.get(), b.get(), 1e3).distance_m;
    EXPECT_LE(std::abs(answer.distance_m - truth_m), answer.bound_m + 1e-7);
  }
}

TEST(FclProbe, ATruncatedConeIsBoundedByItsPieces) {
  const PairDistance answer =
      Distance(Cone{0.04, 0.07, 0.12}, kOrigin, Sphere{0.05}, MakeTranslation(0.2, 0, 0.06));
  EXPECT_EQ(answer.accuracy, Accuracy::kBounded);
  EXPECT_GT(answer.bound_m, 1e-5);
  EXPECT_LT(answer.bound_m, 2e-4);
  EXPECT_LE(std::abs(answer.distance_m - (0.2 - 0.05 - 0.07)), answer.bound_m);
}

}  // namespace
}  // namespace cwm::collision
