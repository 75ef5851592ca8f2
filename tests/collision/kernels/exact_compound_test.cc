// Plates with holes, open and closed meshes, and rays.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

PairDistance Solve(const Shape& a, const Pose& X_FA, const Shape& b, const Pose& X_FB) {
  const auto exact_a = PrepareExact(a), exact_b = PrepareExact(b);
  return ExactDistance({*exact_a, X_FA}, {*exact_b, X_FB});
}

const Pose kHere = Pose::Identity();
const Plate kFrame{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}},
                   {{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}},
                   0.1};

TEST(ExactPlate, LetsABoxThroughItsHole) {
  const PairDistance answer = Solve(kFrame, kHere, Box{{0.8, 0.8, 1}}, MakeTranslation(0, 0, 0));
  EXPECT_NEAR(answer.distance_m, 0.1, 1e-12);
  EXPECT_EQ(answer.accuracy, Accuracy::kExact);
}

TEST(ExactPlate, StopsABoxThatIsWiderThanItsHole) {
  const PairDistance answer =
      Solve(kFrame, kHere, Box{{1.2, 0.2, 0.5}}, MakeTranslation(0, 0, 0.24));
  EXPECT_NEAR(answer.distance_m, -0.01, 1e-9);
  EXPECT_NEAR(answer.normal.z(), 1, 1e-9);
  EXPECT_EQ(answer.accuracy, Accuracy::kExact);  // the same translation separates pieces and hull
}

TEST(ExactPlate, StatesABoundWhereOnlyPiecesAreKnown) {
  const PairDistance answer =
      Solve(Box{{0.2, 0.2, 0.5}}, MakeTranslation(0.45, 0, 0), kFrame, kHere);
  EXPECT_NEAR(answer.distance_m, -0.05, 1e-9);
  EXPECT_EQ(answer.accuracy, Accuracy::kBounded);
  EXPECT_GT(answer.bound_m, 0.1);
}

TEST(ExactMesh, AgreesWithTheSolidThatItTessellates) {
  // Boxes are tessellated exactly, so both must agree up to rounding if separated.
  RandomPairs random(3);
  for (int k = 0; k < 300; ++k) {
    const ShapeKind kinds[] = {ShapeKind::kSphere, ShapeKind::kBox,     ShapeKind::kCylinder,
                               ShapeKind::kCone,   ShapeKind::kCapsule, ShapeKind::kConvex,
                               ShapeKind::kPlate};
    const PosedPair pair = random.Pair(ShapeKind::kBox, kinds[k % 7]);
    const Mesh mesh = MakeMesh(Tessellate(pair.a));
    ASSERT_TRUE(mesh.watertight);
    const PairDistance solid = Solve(pair.a, pair.X_FA, pair.b, pair.X_FB);
    const PairDistance answer = Solve(mesh, pair.X_FA, pair.b, pair.X_FB);
    const double tolerance_m = 1e-8 * SizeOf(pair);
    ASSERT_EQ(answer.distance_m > tolerance_m, solid.distance_m > tolerance_m) << k;
    if (solid.distance_m > tolerance_m) {
      ASSERT_NEAR(answer.distance_m, solid.distance_m, tolerance_m) << k;
      continue;
    }
    // The true depth is between the answer and its bound; an exact answer has its tolerance as
    // bound.
    ASSERT_LE(-answer.distance_m, -solid.distance_m + tolerance_m) << k;
    const double bound_m = answer.accuracy == Accuracy::kExact ? kExactTolerance_m : answer.bound_m;
    ASSERT_GE(-answer.distance_m + bound_m, -solid.distance_m - tolerance_m) << k;
  }
}

TEST(ExactMesh, BoundsDepthsByTheHullsWithinAndAround) {
  // A box of 60 mm in the middle of a mesh of 0.2 x 0.3 x 0.4 m: 0.1 + 0.03 m along x, less the
  // 0.02 m by which it is off.
  const Mesh mesh = MakeMesh(Tessellate(Box{{0.2, 0.3, 0.4}}));
  const PairDistance answer =
      Solve(mesh, kHere, Box{{0.06, 0.06, 0.06}}, MakeTranslation(0.02, 0.01, 0.03));
  EXPECT_NEAR(answer.distance_m, -0.11, 1e-6);
  EXPECT_LE(answer.bound_m, 1e-6);
  EXPECT_NEAR(answer.normal.x(), 1, 1e-6);
  // A cylinder of 48 sides, as deep as its radius and the box.
  const Mesh round = MakeMesh(Tessellate(Cylinder{0.1, 0.4}));
  const PairDistance in_round =
      Solve(round, kHere, Box{{0.06, 0.06, 0.06}}, MakeTranslation(0.05, 0, 0));
  EXPECT_LE(in_round.bound_m, 2e-6);
  EXPECT_NEAR(in_round.distance_m, -0.08, 5e-4) << "less than that by what the sides cut off";
}

TEST(ExactMesh, HoldsWhatLiesInside) {
  const Mesh room = MakeMesh(Tessellate(Box{{2, 2, 2}}));
  const Mesh crate = MakeMesh(Tessellate(Box{{0.2, 0.2, 0.2}}));
  for (const Shape& inner :
       {Shape(Sphere{0.1}), Shape(Box{{0.2, 0.2, 0.2}}), Shape(Capsule{0.1, 0.2}), Shape(crate)}) {
    const PairDistance answer = Solve(room, kHere, inner, MakeTranslation(0.3, 0, 0));
    EXPECT_LT(answer.distance_m, -0.5) << NameOf(KindOf(inner));
    EXPECT_LE(answer.bound_m, 2.0);  // at most the width of the room
    EXPECT_LT(Solve(inner, MakeTranslation(0.3, 0, 0), room, kHere).distance_m, -0.5);
  }
}

TEST(ExactMesh, HasNoInsideWhenOpen) {
  TriangleMesh open = Tessellate(Box{{2, 2, 2}});
  open.triangles.pop_back();
  const PairDistance answer = Solve(MakeMesh(open), kHere, Sphere{0.1}, kHere);
  EXPECT_NEAR(answer.distance_m, 0.9, 1e-12);
  EXPECT_EQ(answer.accuracy, Accuracy::kSurfaceOnly);
}

TEST(ExactMesh, MeetsMeshesAndHalfSpaces) {
  const Mesh crate = MakeMesh(Tessellate(Box{{1, 1, 1}}));
  EXPECT_NEAR(Solve(crate, kHere, crate, MakeTranslation(1.5, 0.2, 0)).distance_m, 0.5, 1e-12);
  EXPECT_LT(Solve(crate, kHere, crate, MakeTranslation(0.9, 0.2, 0)).distance_m, 0);
  EXPECT_NEAR(Solve(crate, MakeTranslation(0, 0, 0.3), HalfSpace{}, kHere).distance_m, -0.2, 1e-12);
}

TEST(ExactRay, FromAHundredKilometresMeetsTheSurfaceWhereOneFromNearbyDoes) {
  RandomPairs random(12);
  std::vector<Shape> shapes = {kFrame, MakeMesh(Tessellate(Capsule{0.3, 0.4}))};
  for (const ShapeKind kind : {ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCylinder,
                               ShapeKind::kCone, ShapeKind::kCapsule, ShapeKind::kConvex}) {
    shapes.push_back(random.ConvexShape(kind));
  }
  constexpr double kFar_m = 1e5, kRounding_m = 1e-9;
  int hits = 0;
  for (const Shape& shape : shapes) {
    const auto exact = PrepareExact(shape);
    const Pose X_FS = random.AnyPose(2);
    const double size = SizeOf({shape, shape});
    for (int k = 0; k < 200; ++k) {
      const Vector3 direction = random.Direction();
      const Vector3 near =
          X_FS * random.VectorOfLength(0.2 * size * random.Uniform(0, 1)) - 4 * size * direction;
      const auto from_near = ExactRay({*exact, X_FS}, {near, direction});
      const auto from_far = ExactRay({*exact, X_FS}, {near - kFar_m * direction, direction});
      // The direction of such a distant ray is rounded, here by 1e-11 m, so it may miss edges.
      if (!from_near || !from_far) continue;
      const double facing = std::abs(from_near->normal.dot(direction));
      if (facing < 0.1 || !from_far->normal.isApprox(from_near->normal, 1e-3)) continue;
      EXPECT_NEAR(from_far->distance_m, from_near->distance_m + kFar_m, kRounding_m)
          << NameOf(KindOf(shape));
      ++hits;
    }
  }
  EXPECT_GT(hits, 300);
}

TEST(ExactRay, MeetsTheSurfaceFromOutsideAndInside) {
  RandomPairs random(11);
  std::vector<Shape> shapes = {kFrame, MakeMesh(Tessellate(Capsule{0.3, 0.4}))};
  for (const ShapeKind kind : {ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCylinder,
                               ShapeKind::kCone, ShapeKind::kCapsule, ShapeKind::kConvex}) {
    for (int i = 0; i < 20; ++i) shapes.push_back(random.ConvexShape(kind));
  }
  for (const Shape& shape : shapes) {
    const auto exact = PrepareExact(shape);
    const Pose X_FS = random.AnyPose(2);
    const double size = SizeOf({shape, shape});
    for (int k = 0; k < 30; ++k) {
      const Vector3 origin = X_FS * random.VectorOfLength(0.4 * size * random.Uniform(0, 1));
      const Ray ray{origin, random.Direction()};
      const Pose X_SF = X_FS.inverse();
      const double start = SignedDistance_m(shape, X_SF * origin);
      const std::optional<RayHit> hit = ExactRay({*exact, X_FS}, ray);
      // Marching by the distance reaches the first surface and never steps over it.
      double t = 0, distance = std::abs(start);
      for (int step = 0; step < 3000 && t < 4 * size && distance > 1e-10 * size; ++step) {
        t += distance;
        distance = std::abs(SignedDistance_m(shape, X_SF * (origin + t * ray.direction)));
      }
      const bool marched_in = distance <= 1e-10 * size;
      if (!hit) {
        EXPECT_FALSE(marched_in && start < 0) << NameOf(KindOf(shape));
        continue;
      }
      const Vector3 at = X_SF * Vector3(origin + hit->distance_m * ray.direction);
      EXPECT_LE(std::abs(SignedDistance_m(shape, at)), 1e-9 * size) << NameOf(KindOf(shape));
      EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
      // A grazing ray marches without end, but no march passes the hit.
      EXPECT_LE(t, hit->distance_m + 1e-6 * size) << NameOf(KindOf(shape));
      if (std::abs(hit->normal.dot(ray.direction)) < 1e-2) continue;
      EXPECT_EQ(hit->normal.dot(ray.direction) > 0, start < 0) << NameOf(KindOf(shape));
    }
  }
}

}  // namespace
}  // namespace cwm::collision
