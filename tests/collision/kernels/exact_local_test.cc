// Shapes of very different sizes, and hulls with rounded corners.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

constexpr double kExact_m = 1e-7;  // the accuracy of Accuracy::kExact

TEST(ExactDistance, OfAHallFloorIsAsRightAsThatOfATile) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-40, 40), height(1e-4, 0.5);
  std::normal_distribution<double> normal;
  const auto floor = PrepareExact(Box{{100, 100, 1}});
  const auto ground = PrepareExact(HalfSpace{});
  const Pose X_WF = MakeTranslation(0, 0, -0.5);
  const std::vector<Shape> shapes = {Cylinder{0.04, 0.12}, Cone{0.03, 0.05, 0.1},
                                     Box{{0.1, 0.2, 0.3}}, Cone{0.05, 0, 0.2}};
  double worst_m = 0;
  for (int k = 0; k < 400; ++k) {
    const auto cup = PrepareExact(shapes[k % shapes.size()]);
    const Quaternion q{normal(random), normal(random), normal(random), normal(random)};
    Pose X_WC = MakePose({place(random), place(random), 1}, q.normalized());
    const Pose I = Pose::Identity();
    X_WC.translation().z() += height(random) - ExactDistance({*cup, X_WC}, {*ground, I}).distance_m;
    const double truth_m = ExactDistance({*cup, X_WC}, {*ground, I}).distance_m;
    for (const PairDistance& answer : {ExactDistance({*floor, X_WF}, {*cup, X_WC}),
                                       ExactDistance({*cup, X_WC}, {*floor, X_WF})}) {
      ASSERT_EQ(answer.accuracy, Accuracy::kExact) << k << " " << answer.bound_m;
      ASSERT_NEAR(answer.distance_m, truth_m, kExact_m) << k;
      worst_m = std::max(worst_m, std::abs(answer.distance_m - truth_m));
    }
  }
  EXPECT_LT(worst_m, 1e-9);  // for shapes of up to 0.3 m
}

TEST(ExactDistance, BesideALargeBoxIsThatToItsNearestFaceEdgeOrCorner) {
  const auto box = PrepareExact(Box{{10, 20, 30}}), cube = PrepareExact(Box{{0.1, 0.1, 0.1}});
  const Pose I = Pose::Identity();
  const auto distance_m = [&](double x, double y, double z) {
    return ExactDistance({*box, I}, {*cube, MakeTranslation(x, y, z)}).distance_m;
  };
  EXPECT_NEAR(distance_m(9, 3, -7), 9 - 5.05, 1e-12);
  EXPECT_NEAR(distance_m(9, 14, -7), std::hypot(9 - 5.05, 14 - 10.05), 1e-12);
  EXPECT_NEAR(distance_m(-9, 14, 20), Vector3(3.95, 3.95, 4.95).norm(), 1e-12);
}

TEST(ExactDistance, OfLargeRoundShapesStatesWhatItLeavesOpen) {
  RandomPairs random(8);
  std::mt19937 engine(8);
  std::uniform_real_distribution<double> place(-1, 1);
  const auto silo = PrepareExact(Cylinder{100, 200}), ground = PrepareExact(HalfSpace{});
  const Pose I = Pose::Identity();
  for (int k = 0; k < 100; ++k) {
    // Above the silo its lid acts as a plane.
    const auto cup = PrepareExact(Cone{0.03, 0.05, 0.1});
    const Quaternion q(place(engine), place(engine), place(engine), place(engine));
    const Pose X_WC = MakePose({50 * place(engine), 50 * place(engine), 0.3}, q.normalized());
    const PairDistance answer = ExactDistance({*silo, MakeTranslation(0, 0, -100)}, {*cup, X_WC});
    const double truth_m = ExactDistance({*ground, I}, {*cup, X_WC}).distance_m;
    const double allowed_m =
        answer.accuracy == Accuracy::kExact ? kExact_m : answer.bound_m + kExact_m;
    EXPECT_NEAR(answer.distance_m, truth_m, allowed_m) << k;
  }
}

// A barrel of 0.1 mm and a rod of 1.4 m, a picometre apart. The simplices of GJK are so thin that
// rounding once put the nearest point 0.3 um nearer than a separating plane allows.
TEST(ExactDistance, OfAGrainBesideARodIsNoNearerThanAPlaneBetweenThem) {
  const auto grain = PrepareExact(Cylinder{0.00013441536157768414, 0.00010228078464367771});
  const auto rod = PrepareExact(Capsule{9.7488182196107484e-05, 1.3786670202733937});
  Pose X_GR = Pose::Identity();
  X_GR.linear() << 0.56327237425758203, -0.51708250330197891, 0.64447646751234089,
      0.39180902417644092, 0.85386413310765974, 0.342639359627889, -0.72746815804688747,
      0.059512410228991494, 0.68355566858640326;
  X_GR.translation() = Vector3(0.043873463069003416, 0.023576226304235458, 0.046773891850465467);
  const PairDistance answer = ExactDistance({*grain, Pose::Identity()}, {*rod, X_GR});
  EXPECT_NEAR(answer.distance_m, 1e-12, 1e-9);
  const PairDistance swapped = ExactDistance({*rod, X_GR}, {*grain, Pose::Identity()});
  EXPECT_NEAR(swapped.distance_m, 1e-12, 1e-9);
}

TEST(ExactRay, HitsAHullWithACornerOnAnEdgeAndRoundedCorners) {
  TriangleMesh mesh = Tessellate(Cylinder{0.05, 0.1}, 1e-4);
  for (Vector3& v : mesh.vertices) v = v.cast<float>().cast<double>();  // as clients send them
  const auto rounded = PrepareExact(Convex{std::make_shared<const TriangleMesh>(mesh)});
  const auto cylinder = PrepareExact(Cylinder{0.05, 0.1});
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-0.0499, 0.0499);
  int hits = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3 target(place(random), place(random), place(random));
    if (target.head<2>().norm() > 0.0495) continue;  // inside the chords
    const Vector3 origin = Vector3(place(random), place(random), place(random)).normalized();
    const Ray ray{origin, (target - origin).normalized()};
    const auto hit = ExactRay({*rounded, Pose::Identity()}, ray);
    const auto truth = ExactRay({*cylinder, Pose::Identity()}, ray);
    ASSERT_TRUE(hit.has_value() && truth.has_value()) << k;
    EXPECT_GE(hit->distance_m, truth->distance_m - 1e-7);
    EXPECT_LE(hit->distance_m, (target - origin).norm());
    ++hits;
  }
  EXPECT_GT(hits, 1000);
}

}  // namespace
}  // namespace cwm::collision
