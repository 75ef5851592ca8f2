// Distances that can be computed by hand.
#include <gtest/gtest.h>

#include "collision/geometry/validation.h"

#include <string>

#include "collision/kernels/exact.h"

namespace cwm::collision {
namespace {

constexpr double kTolerance_m = 1e-12;

double DistanceAlongX(const Shape& a, const Shape& b, double x_m) {
  const auto exact_a = PrepareExact(a), exact_b = PrepareExact(b);
  const Pose X_FA = Pose::Identity(), X_FB = MakeTranslation(x_m, 0, 0);
  return ExactDistance({*exact_a, X_FA}, {*exact_b, X_FB}).distance_m;
}

const Box kUnitBox{{1, 1, 1}};

TEST(ExactKnownAnswers, UnitBoxAgainstRoundShapesAtItsCentreHeight) {
  for (const Shape& shape :
       {Shape(Sphere{0.25}), Shape(Cylinder{0.25, 0.25}), Shape(Capsule{0.25, 0.25})}) {
    EXPECT_NEAR(DistanceAlongX(kUnitBox, shape, 0.2), -0.55, kTolerance_m) << NameOf(KindOf(shape));
    EXPECT_NEAR(DistanceAlongX(kUnitBox, shape, 1.0), 0.25, kTolerance_m) << NameOf(KindOf(shape));
  }
}

TEST(ExactKnownAnswers, UnitBoxAgainstConeMeetsItsBase) {
  EXPECT_NEAR(DistanceAlongX(kUnitBox, Cone{0.25, 0, 0.25}, 0.2), -0.55, 1e-9);
  EXPECT_NEAR(DistanceAlongX(kUnitBox, Cone{0.25, 0, 0.25}, 1.0), 0.25, kTolerance_m);
}

TEST(ExactKnownAnswers, UnitBoxAgainstTwoMetreBox) {
  EXPECT_NEAR(DistanceAlongX(kUnitBox, Box{{2, 2, 2}}, 0.2), -1.30, kTolerance_m);
  EXPECT_NEAR(DistanceAlongX(kUnitBox, Box{{2, 2, 2}}, 1.6), 0.10, kTolerance_m);
}

TEST(ExactKnownAnswers, TwoSpheres) {
  EXPECT_NEAR(DistanceAlongX(Sphere{0.25}, Sphere{0.25}, 0.2), -0.30, kTolerance_m);
  EXPECT_NEAR(DistanceAlongX(Sphere{0.25}, Sphere{0.25}, 1.0), 0.50, kTolerance_m);
}

TEST(ExactKnownAnswers, SpheresWithOneCentreStillPart) {
  const auto sphere = PrepareExact(Sphere{0.25});
  const Pose X = Pose::Identity();
  const PairDistance answer = ExactDistance({*sphere, X}, {*sphere, X});
  EXPECT_NEAR(answer.distance_m, -0.5, kTolerance_m);
  EXPECT_NEAR(answer.normal.norm(), 1, 1e-15);
}

TEST(ExactKnownAnswers, CylindersOnOneAxisPartSideways) {
  EXPECT_NEAR(DistanceAlongX(Cylinder{0.1, 1}, Cylinder{0.2, 1}, 0), -0.3, kTolerance_m);
  EXPECT_NEAR(DistanceAlongX(Cylinder{0.1, 1}, Cylinder{0.2, 1}, 0.5), 0.2, kTolerance_m);
}

TEST(ExactKnownAnswers, CylinderFloatsAboveAndSinksIntoHalfSpace) {
  const auto ground = PrepareExact(HalfSpace{}), cylinder = PrepareExact(Cylinder{0.1, 0.4});
  const Pose X_FG = Pose::Identity(), above = MakeTranslation(3, 2, 0.25),
             sunk = MakeTranslation(3, 2, 0.15);
  EXPECT_NEAR(ExactDistance({*ground, X_FG}, {*cylinder, above}).distance_m, 0.05, kTolerance_m);
  const PairDistance answer = ExactDistance({*cylinder, sunk}, {*ground, X_FG});
  EXPECT_NEAR(answer.distance_m, -0.05, kTolerance_m);
  EXPECT_NEAR(answer.normal.z(), -1, 1e-15);
}

TEST(ExactKnownAnswers, HalfSpacesThatFaceEachOtherAreAGapOrALayer) {
  const auto half = PrepareExact(HalfSpace{});
  const Pose X_FA =
      MakePose({1, 2, 3}, Quaternion(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized())));
  for (const double gap_m : {0.3, -0.2}) {
    const Pose X_FB = X_FA * MakePose({5, -4, gap_m}, Quaternion(0, 1, 0, 0));
    const PairDistance answer = ExactDistance({*half, X_FA}, {*half, X_FB});
    EXPECT_NEAR(answer.distance_m, gap_m, kTolerance_m);
    EXPECT_EQ(answer.accuracy, Accuracy::kExact);
    const Vector3 up = X_FA.linear().col(2);
    EXPECT_NEAR((answer.normal - up).norm(), 0, kTolerance_m);
    EXPECT_NEAR(up.dot(answer.point_a - X_FA.translation()), 0, kTolerance_m);
    EXPECT_NEAR(up.dot(answer.point_b - X_FB.translation()), 0, kTolerance_m);
    EXPECT_EQ(ExactOverlap({*half, X_FA}, {*half, X_FB}), gap_m < 0);
  }
  // Touching is not a collision.
  const Pose X_FC = MakePose({0, 0, 0}, Quaternion(0, 1, 0, 0));
  EXPECT_FALSE(ExactOverlap({*half, Pose::Identity()}, {*half, X_FC}));
}

TEST(ExactKnownAnswers, OtherHalfSpacesOverlapWithoutEnd) {
  const auto half = PrepareExact(HalfSpace{});
  const Quaternion facing(0, 1, 0, 0);
  for (const Pose& X_FB :
       {MakeTranslation(0, 0, 1000), MakeTranslation(0, 0, -1000),
        MakePose({0, 0, 1}, Quaternion(Eigen::AngleAxisd(1.5, Vector3::UnitX()))),
        MakePose({0, 0, 1}, Quaternion(Eigen::AngleAxisd(1e-9, Vector3::UnitX())) * facing)}) {
    const PairDistance answer = ExactDistance({*half, Pose::Identity()}, {*half, X_FB});
    EXPECT_EQ(answer.distance_m, -kMaxCoordinate_m);
    EXPECT_EQ(answer.accuracy, Accuracy::kDegraded);
    EXPECT_TRUE(ExactOverlap({*half, Pose::Identity()}, {*half, X_FB}));
  }
}

TEST(ExactKnownAnswers, BeyondTheLimitIsALowerBoundAboveIt) {
  const Shape shapes[] = {Sphere{0.1}, Box{{0.1, 0.2, 0.3}}, Cylinder{0.1, 0.2}, Cone{0.1, 0, 0.2},
                          Capsule{0.1, 0.2}};
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      const auto exact_a = PrepareExact(a), exact_b = PrepareExact(b);
      const Pose X_FA = Pose::Identity(), X_FB = MakeTranslation(2, 1, 0.3);
      const double exact = ExactDistance({*exact_a, X_FA}, {*exact_b, X_FB}).distance_m;
      const double bound = ExactDistance({*exact_a, X_FA}, {*exact_b, X_FB}, 0.5).distance_m;
      EXPECT_GT(bound, 0.5);
      EXPECT_LE(bound, exact + kTolerance_m);
      EXPECT_NEAR(ExactDistance({*exact_a, X_FA}, {*exact_b, X_FB}, 5.0).distance_m, exact, 1e-11);
    }
  }
}

}  // namespace
}  // namespace cwm::collision
