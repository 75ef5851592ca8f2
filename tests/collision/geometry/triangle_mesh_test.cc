#include "collision/geometry/triangle_mesh.h"

#include <gtest/gtest.h>

#include "collision/geometry/tessellate.h"
#include "tests/collision/geometry/unshared.h"

namespace cwm {
namespace {

TriangleMesh Cube(double x_m) {
  TriangleMesh mesh = Tessellate(Box{{1, 1, 1}});
  for (Vector3& v : mesh.vertices) v.x() += x_m;
  return mesh;
}

TEST(IsWatertight, AsksForPlacesNotForIndices) {
  const TriangleMesh cube = Cube(0);
  EXPECT_TRUE(IsWatertight(cube));
  TriangleMesh loose = Unshared(cube);
  ASSERT_EQ(loose.vertices.size(), 36u);
  EXPECT_TRUE(IsWatertight(loose));
  TriangleMesh open = loose;
  open.triangles.pop_back();
  EXPECT_FALSE(IsWatertight(open));
  TriangleMesh turned = loose;
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  EXPECT_FALSE(IsWatertight(turned));
  loose.vertices[7].x() += 1e-9;
  EXPECT_FALSE(IsWatertight(loose)) << "a crack";
}

TEST(IsWatertight, PassesOverTrianglesWhoseCornersCoincide) {
  TriangleMesh pole = Unshared(Cube(0));
  const auto first = static_cast<std::uint32_t>(pole.vertices.size());
  const Vector3 corner = pole.vertices[0], other = pole.vertices[1];
  pole.vertices.insert(pole.vertices.end(), {corner, corner, other});
  pole.triangles.push_back({first, first + 1, first + 2});
  EXPECT_TRUE(IsWatertight(pole));
}

// If positions were merged, the common edge would have four triangles.
TEST(IsWatertight, HoldsOfSolidsThatTouchAlongAnEdge) {
  TriangleMesh two = Cube(0);
  TriangleMesh other = Cube(1);
  for (Vector3& v : other.vertices) v.y() += 1;
  const auto offset = static_cast<std::uint32_t>(two.vertices.size());
  two.vertices.insert(two.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const TriangleMesh::Triangle& t : other.triangles) {
    two.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  EXPECT_TRUE(IsWatertight(two));
}

}  // namespace
}  // namespace cwm
