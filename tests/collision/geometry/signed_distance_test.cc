#include "collision/geometry/signed_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "collision/geometry/aabb.h"
#include "collision/geometry/coefficients.h"
#include "collision/geometry/distance_to_shape.h"
#include "collision/geometry/tessellate.h"

namespace cwm {
namespace {

std::vector<Shape> Solids() {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Vector3> points;
  for (int i = 0; i < 60; ++i)
    points.push_back(Vector3{normal(random), normal(random), normal(random)});
  return {Sphere{0.7},
          Box{{1, 0.5, 2}},
          Cylinder{0.5, 1.2},
          Cone{0.6, 0, 1},
          Cone{0.2, 0.7, 0.4},
          Capsule{0.3, 1},
          Plate{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                {{{0.3, 0.3}, {0.3, 0.7}, {0.7, 0.7}, {0.7, 0.3}}},
                0.2},
          Convex{std::make_shared<const TriangleMesh>(ConvexHull3(points))}};
}

TEST(SignedDistance, AgreesWithTheTessellationInsideAndOutside) {
  constexpr double kDeviation_m = 1e-3;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (const Shape& shape : Solids()) {
    const Mesh mesh = MakeMesh(Tessellate(shape, kDeviation_m));
    ASSERT_TRUE(mesh.watertight) << NameOf(KindOf(shape));
    EXPECT_GT(SignedVolume_m3(*mesh.mesh), 0);
    for (int k = 0; k < 100; ++k) {
      const Vector3 p(coordinate(random), coordinate(random), coordinate(random));
      EXPECT_NEAR(SignedDistance_m(shape, p), SignedDistance_m(mesh, p), kDeviation_m + 1e-12)
          << NameOf(KindOf(shape)) << " at " << p.transpose();
    }
  }
}

TEST(DistanceToShape, IsTheSignedDistanceToTheBit) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (const Shape& shape : Solids()) {
    const DistanceToShape distance_m(shape);
    for (int k = 0; k < 300; ++k) {
      Vector3 p(coordinate(random), coordinate(random), coordinate(random));
      for (int axis = 0; axis < 3; ++axis) {
        if ((k >> axis & 1) != 0) p[axis] = 0;
      }
      EXPECT_EQ(distance_m(p), SignedDistance_m(shape, p)) << NameOf(KindOf(shape));
    }
  }
}

TEST(SignedDistance, NearestPointLiesOnTheSurfaceAlongTheNormal) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (const Shape& shape : Solids()) {
    for (int k = 0; k < 300; ++k) {
      // Includes points on the axes and planes of symmetry, where the gradient is not unique.
      Vector3 p(coordinate(random), coordinate(random), coordinate(random));
      for (int axis = 0; axis < 3; ++axis) {
        if ((k >> axis & 1) != 0) p[axis] = 0;
      }
      const SurfacePoint at = NearestSurfacePoint(shape, p);
      EXPECT_NEAR(at.normal.norm(), 1, 1e-12);
      EXPECT_NEAR(SignedDistance_m(shape, at.nearest), 0, 1e-12) << NameOf(KindOf(shape));
      EXPECT_LE((p - at.nearest - at.signed_distance_m * at.normal).norm(), 1e-12)
          << NameOf(KindOf(shape)) << " at " << p.transpose();
    }
  }
}

TEST(TightBounds, TouchTheShapeOnEverySide) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (const Shape& shape : Solids()) {
    const Pose X_FS = MakePose(
        {1, 2, 3},
        Quaternion{normal(random), normal(random), normal(random), normal(random)}.normalized());
    const Aabb bounds = TightBounds(shape, X_FS);
    const Aabb sampled = TightBounds(MakeMesh(Tessellate(shape, 1e-4)), X_FS);
    EXPECT_TRUE(bounds.contains(
        Aabb(sampled.min() + Vector3::Constant(1e-12), sampled.max() - Vector3::Constant(1e-12))));
    EXPECT_LE((bounds.sizes() - sampled.sizes()).maxCoeff(), 3e-4) << NameOf(KindOf(shape));
  }
}

TEST(ConvexHull3, HoldsItsPointsAndIsWatertight) {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> grid(0, 5);
  for (int k = 0; k < 100; ++k) {
    std::vector<Vector3> points;  // on a grid: many coplanar and collinear points
    for (int i = 0; i < 60; ++i) points.emplace_back(grid(random), grid(random), grid(random));
    const Convex hull{std::make_shared<const TriangleMesh>(ConvexHull3(points))};
    ASSERT_TRUE(IsWatertight(*hull.hull));
    for (const Vector3& p : points) EXPECT_LE(SignedDistance_m(hull, p), 1e-10);
  }
  EXPECT_TRUE(ConvexHull3({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).triangles.empty());
}

TEST(Coefficients, OfAConePointFromTheApexIntoIt) {
  const std::vector<double> c = Coefficients(Cone{1, 0, 1}, MakeTranslation(0, 0, 0.5));
  ASSERT_EQ(c.size(), 7u);
  EXPECT_NEAR(c[2], 1, 1e-15);
  EXPECT_NEAR(c[5], -1, 1e-15);
  EXPECT_NEAR(c[6], std::atan(1), 1e-15);
}

}  // namespace
}  // namespace cwm
