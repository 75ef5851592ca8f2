#include "collision/kernels/inner_spheres.h"

#include <gtest/gtest.h>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/exact_geometry.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

constexpr double kSize_m = 0.2;  // a link's
constexpr double kSpared_m = 1e-6;

// An L of two boxes, whose hull contains free space.
Mesh Angle() {
  TriangleMesh mesh;
  const std::array<Vector2, 6> outline = {Vector2{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  for (const double z : {0.0, 1.0}) {
    for (const Vector2& p : outline) {
      mesh.vertices.push_back(kSize_m / 3 * Vector3(p.x(), p.y(), z));
    }
  }
  for (const auto& [a, b, c] : {std::array{0U, 1U, 2U}, {0U, 2U, 3U}, {0U, 3U, 4U}, {0U, 4U, 5U}}) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + 6, b + 6, c + 6});
  }
  for (std::uint32_t k = 0; k < 6; ++k) {
    const std::uint32_t next = (k + 1) % 6;
    mesh.triangles.push_back({k, next, next + 6});
    mesh.triangles.push_back({k, next + 6, k + 6});
  }
  EXPECT_TRUE(IsWatertight(mesh));
  return {std::make_shared<const TriangleMesh>(std::move(mesh)), true};
}

Mesh Closed(TriangleMesh mesh) {
  return {std::make_shared<const TriangleMesh>(std::move(mesh)), true};
}

TEST(InnerBalls, HaveNoTriangleInThem) {
  const Mesh ball = Closed(Tessellate(Sphere{0.5 * kSize_m}, 1e-3));
  const Mesh can = Closed(Tessellate(Cylinder{0.25 * kSize_m, kSize_m}, 1e-4));
  for (const Mesh& mesh : {ball, can, Angle()}) {
    const TriangleTree tree(*mesh.mesh);
    const std::vector<InnerSphere> balls = FindInnerSpheres(tree, kSpared_m);
    ASSERT_FALSE(balls.empty());
    EXPECT_LE(balls.size(), kMaxInnerSpheres);
    for (const InnerSphere& each : balls) {
      EXPECT_GT(each.radius_m, 0);
      EXPECT_LE(each.radius_m, balls.front().radius_m);
      EXPECT_TRUE(tree.Contains(each.centre));
      const double off_m = tree.NearestPoint(each.centre, kSize_m).distance_m;
      EXPECT_GE(off_m, each.radius_m + kSpared_m - 1e-12);
    }
  }
}

TEST(InnerBalls, ReachIntoBothArmsOfAnAngle) {
  const TriangleTree tree(*Angle().mesh);
  bool along_x = false, along_y = false;
  for (const InnerSphere& each : FindInnerSpheres(tree, kSpared_m)) {
    along_x = along_x || each.centre.x() > 0.6 * kSize_m;
    along_y = along_y || each.centre.y() > 0.6 * kSize_m;
  }
  EXPECT_TRUE(along_x);
  EXPECT_TRUE(along_y);
}

TEST(InnerBalls, OverlapWhereTheirMeshesDo) {
  constexpr int kPairs = 2000;
  const Mesh mesh = Angle();
  const ExactGeometry geometry(mesh);
  const std::vector<InnerSphere> balls = FindInnerSpheres(*geometry.tree(), kSpared_m);
  RandomPairs random(71);
  int result = 0, overlapping = 0;
  for (int k = 0; k < kPairs; ++k) {
    const Pose X_AB = random.AnyPose(1.2 * kSize_m), I = Pose::Identity();
    const bool plain = ExactDistance({geometry, I}, {geometry, X_AB}).distance_m < 0;
    overlapping += plain ? 1 : 0;
    if (!SpheresOverlap(balls, balls, X_AB)) continue;
    EXPECT_TRUE(plain);
    ++result;
  }
  EXPECT_GT(result, overlapping / 2);
  EXPECT_GT(overlapping, kPairs / 10);
}

TEST(InnerBalls, AreNoneOfASolidThinnerThanWhatIsSpared) {
  const TriangleTree tree(Tessellate(Box{{kSize_m, kSize_m, 1e-3}}, 1e-3));
  EXPECT_TRUE(FindInnerSpheres(tree, 1e-3).empty());
}

}  // namespace
}  // namespace cwm::collision
