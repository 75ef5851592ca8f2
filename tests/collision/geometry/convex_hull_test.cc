#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "collision/geometry/shape.h"
#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/geometry/triangle.h"
#include "collision/geometry/validation.h"

namespace cwm {
namespace {

void ExpectSoundHull(const std::vector<Vector3>& points, double size_m) {
  const TriangleMesh hull = ConvexHull3(points);
  ASSERT_FALSE(hull.triangles.empty());
  EXPECT_TRUE(IsWatertight(hull));
  EXPECT_GT(SignedVolume_m3(hull), 0);
  // Euler's formula: V - E + F = 2 with E = 3 F / 2.
  EXPECT_EQ(2 * hull.vertices.size(), hull.triangles.size() + 4);
  const double rounding_m = 1e-11 * size_m;  // ten times the promise of ConvexHull3
  for (const TriangleMesh::Triangle& t : hull.triangles) {
    const Vector3 &a = hull.vertices[t[0]], &b = hull.vertices[t[1]], &c = hull.vertices[t[2]];
    if (!ReliableNormal(a, b, c)) continue;
    // In extended precision, because the planes of slivers are as inaccurate as their heights are
    // small.
    using Long = Eigen::Matrix<long double, 3, 1>;
    const Long at = a.cast<long double>();
    const Long normal =
        (b.cast<long double>() - at).cross(c.cast<long double>() - at).stableNormalized();
    for (const Vector3& p : points) {
      ASSERT_LE(static_cast<double>(normal.dot(p.cast<long double>() - at)), rounding_m);
    }
  }
}

TEST(ConvexHull3, OfRandomPointsHoldsThemAll) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    std::vector<Vector3> points;
    for (int i = 0; i < 10 + 20 * k; ++i) {
      points.push_back(Vector3{normal(random), normal(random), normal(random)});
      if (k % 2 == 1) points.back().normalize();  // every point is a corner
    }
    ExpectSoundHull(points, 8);
  }
}

TEST(ConvexHull3, OfGridsAndPrismsHoldsThemAll) {
  std::vector<Vector3> grid;
  for (int i = 0; i < 343; ++i) grid.emplace_back(i % 7, i / 7 % 7, i / 49);
  ExpectSoundHull(grid, 12);
  EXPECT_EQ(ConvexHull3(grid).vertices.size(), 8u);
  std::vector<Vector3> prism;
  for (int i = 0; i < 128; ++i) {
    const int corner = i / 2;
    const double angle = 2 * std::numbers::pi * corner / 64;
    prism.emplace_back(std::cos(angle), std::sin(angle), i % 2);
  }
  ExpectSoundHull(prism, 3);
}

// Grid points of rotated boxes, rounded in different ways. No point on an edge or face is exactly
// on the box, so the hull has slivers as thin as the rounding.
TEST(ConvexHull3, OfTurnedBoxesThatWereRoundedHoldsAllTheirPoints) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto rounded = [](double x, int way) {
    if (way == 0) return x;
    return way == 1 ? static_cast<double>(static_cast<float>(x)) : std::round(x * 1e6) / 1e6;
  };
  for (int k = 0; k < 240; ++k) {
    Quaternion turn{normal(random), normal(random), normal(random), normal(random)};
    turn.normalize();
    const int parts = 2 + k % 4, way = k % 3;
    std::vector<Vector3> points;
    for (int i = 0; i < (parts + 1) * (parts + 1) * (parts + 1); ++i) {
      const Vector3 at(i % (parts + 1), i / (parts + 1) % (parts + 1),
                       i / ((parts + 1) * (parts + 1)));
      const Vector3 p = turn * (2 * at / parts - Vector3::Ones()).cwiseProduct(Vector3(3, 2, 1));
      points.emplace_back(rounded(p.x(), way), rounded(p.y(), way), rounded(p.z(), way));
    }
    SCOPED_TRACE(k);
    ExpectSoundHull(points, 8);
  }
}

TEST(ConvexHull3, OfAPrismOverACircleTakesNoCubeOfItsCorners) {
  std::vector<Vector3> prism;
  for (int i = 0; i < 2000; ++i) {
    const int corner = i / 2;
    const double angle = 2 * std::numbers::pi * corner / 1000;
    prism.emplace_back(std::cos(angle), std::sin(angle), 0.02 * (i % 2));
  }
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(ConvexHull3(prism).vertices.size(), prism.size());
  // measured: 0.8 s on a busy machine; searching all faces at each step took 13 s.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

// A box with a vertex in the middle of a bottom edge, kept watertight by a triangle without area.
TriangleMesh BoxWithACornerOnAnEdge() {
  TriangleMesh mesh = Tessellate(Box{{1, 1, 1}});
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0, -0.5, -0.5);  // between vertices 0 and 1
  for (TriangleMesh::Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i], to = t[(i + 1) % 3], apex = t[(i + 2) % 3];
      if (from != 0 || to != 1) continue;
      t = {0, middle, apex};
      mesh.triangles.push_back({middle, 1, apex});
      mesh.triangles.push_back({0, 1, middle});
      return mesh;
    }
  }
  return mesh;
}

TEST(SignedDistance, OfAHullIgnoresItsTrianglesWithoutArea) {
  const Shape hull = Convex{std::make_shared<const TriangleMesh>(BoxWithACornerOnAnEdge())};
  ASSERT_FALSE(FindViolation(hull).has_value());
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 p(place(random), place(random), place(random));
    ASSERT_NEAR(SignedDistance_m(hull, p), SignedDistance_m(Box{{1, 1, 1}}, p), 1e-12);
  }
}

}  // namespace
}  // namespace cwm
