#include "collision/geometry/tessellate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collision/geometry/signed_distance.h"

namespace cwm {
namespace {

TEST(Tessellate, MakesClosedOutwardMeshesWithinTheDeviation) {
  const std::vector<Shape> shapes = {
      Sphere{0.7},
      Box{{1, 0.5, 2}},
      Cylinder{0.5, 1.2},
      Cone{0.6, 0, 1},
      Cone{0, 0.6, 1},
      Cone{0.2, 0.7, 0.4},
      Capsule{0.3, 1},
      HalfSpace{},
      Plate{{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {2, 1}, {2, 0}},  // clockwise
            {{{0.3, 0.3}, {0.3, 0.7}, {0.7, 0.7}, {0.7, 0.3}}},
            0.2}};
  constexpr double kDeviation_m = 1e-3;
  for (const Shape& shape : shapes) {
    const TriangleMesh mesh = Tessellate(shape, kDeviation_m);
    const std::string name(NameOf(KindOf(shape)));
    EXPECT_TRUE(IsWatertight(mesh)) << name;
    EXPECT_GT(SignedVolume_m3(mesh), 0) << name;
    if (KindOf(shape) == ShapeKind::kHalfSpace) continue;  // a slab stands for it
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
      for (const Vector3& p : {a, Vector3((a + b) / 2), Vector3((a + b + c) / 3)}) {
        EXPECT_LE(SignedDistance_m(shape, p), 1e-12) << name;
        EXPECT_GE(SignedDistance_m(shape, p), -kDeviation_m) << name;
      }
    }
  }
}

}  // namespace
}  // namespace cwm
