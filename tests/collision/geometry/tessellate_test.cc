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
    if (KindOf(shape) == ShapeKind::kHalfSpace) continue;  // tessellated as a slab
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
      for (const Vector3& p : {a, Vector3((a + b) / 2), Vector3((a + b + c) / 3)}) {
        EXPECT_LE(SignedDistance_m(shape, p), 1e-12) << name;
        EXPECT_GE(SignedDistance_m(shape, p), -kDeviation_m) << name;
      }
    }
  }
}

TEST(Tessellate, StatesTheDeviationThatItsChordsReallyHave) {
  constexpr double kLarge_m = 50;  // kMaxSegments does not suffice for the default
  for (const Shape& shape : std::vector<Shape>{
           Sphere{0.7}, Sphere{kLarge_m}, Cylinder{0.5, 1.2}, Cylinder{kLarge_m, 1},
           Cone{0.6, 0, 1}, Cone{kLarge_m - 1, kLarge_m, 100}, Capsule{kLarge_m, 1}}) {
    const std::string name(NameOf(KindOf(shape)));
    const TriangleMesh mesh = Tessellate(shape);
    double deepest_m = 0;
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
      for (const Vector3& p :
           {Vector3((a + b) / 2), Vector3((a + c) / 2), Vector3((a + b + c) / 3)}) {
        deepest_m = std::max(deepest_m, -SignedDistance_m(shape, p));
      }
    }
    EXPECT_LE(deepest_m, DeviationBound_m(shape) * (1 + 1e-9)) << name;
    EXPECT_GE(deepest_m, 0.3 * DeviationBound_m(shape)) << name << ": a bound far off says little";
  }
  EXPECT_LE(DeviationBound_m(Sphere{3.3}), kDefaultDeviation_m);
  EXPECT_GT(DeviationBound_m(Sphere{3.4}), kDefaultDeviation_m);
  EXPECT_LE(DeviationBound_m(Cylinder{6.6, 1}), kDefaultDeviation_m);
  EXPECT_GT(DeviationBound_m(Cylinder{6.7, 1}), kDefaultDeviation_m);
  EXPECT_EQ(DeviationBound_m(Box{{1, 2, 3}}), 0);
}

}  // namespace
}  // namespace cwm
