// Lower bounds from convex solids around a pair: never larger than the distance.
#include <gtest/gtest.h>

#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/exact_geometry.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

// A ball whose vertices are moved inwards, some of them far.
Shape DentedMesh(RandomPairs& random) {
  TriangleMesh mesh = Tessellate(Shape(Sphere{0.1}), 1e-3);
  for (Vector3& vertex : mesh.vertices) vertex *= 1 - random.Uniform(0, 0.4);
  return MakeMesh(std::move(mesh));
}

// A mesh with too many vertices for a hull; its bounding box is used instead.
Shape LargeMesh() { return MakeMesh(Tessellate(Shape(Sphere{0.1}), 1e-5)); }

Shape OpenMesh() {
  TriangleMesh mesh = Tessellate(Shape(Cylinder{0.05, 0.2}), 1e-3);
  mesh.triangles.resize(mesh.triangles.size() / 2);
  return MakeMesh(std::move(mesh));
}

Shape PlateWithAHole() {
  return Plate{{{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}},
               {{{-0.05, -0.05}, {0.05, -0.05}, {0.05, 0.05}, {-0.05, 0.05}}},
               0.02};
}

TEST(LowerBound, IsNoMoreThanTheDistance) {
  RandomPairs random(5);
  const std::vector<Shape> shapes = {DentedMesh(random), LargeMesh(),      OpenMesh(),
                                     PlateWithAHole(),   Sphere{0.1},      Box{{0.1, 0.2, 0.05}},
                                     Capsule{0.03, 0.2}, Cone{0.1, 0, 0.2}};
  std::vector<std::shared_ptr<const ExactGeometry>> prepared;
  for (const Shape& shape : shapes) prepared.push_back(PrepareExact(shape));
  int result = 0, close = 0;
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    for (std::size_t b = 0; b < shapes.size(); ++b) {
      for (int k = 0; k < 60; ++k) {
        Pose X_FB = MakePose(Vector3::Zero(), Quaternion(random.Rotation()));
        X_FB.translation() = random.VectorOfLength(random.Uniform(0.05, 0.6));
        const PlacedExact placed_a{*prepared[a], Pose::Identity()}, placed_b{*prepared[b], X_FB};
        const std::optional<double> bound_m = ExactLowerBound_m(placed_a, placed_b);
        if (!bound_m) continue;
        const double distance_m = ExactDistance(placed_a, placed_b).distance_m;
        EXPECT_GT(*bound_m, 0);
        EXPECT_LE(*bound_m, distance_m + 1e-12) << a << " " << b;
        ++result;
        close += *bound_m > 0.9 * distance_m ? 1 : 0;
      }
    }
  }
  EXPECT_GT(result, 1000);
  EXPECT_GT(close, result / 4);
}

TEST(LowerBound, IsNoneWhereTheDistanceIsToldAsSoonOrNothingIsAround) {
  const auto mesh = PrepareExact(LargeMesh()), ball = PrepareExact(Sphere{0.1}),
             ground = PrepareExact(HalfSpace{});
  const Pose at = Pose::Identity(), far = MakeTranslation(0, 0, 1);
  EXPECT_FALSE(ExactLowerBound_m({*ball, at}, {*ball, far}));
  EXPECT_FALSE(ExactLowerBound_m({*ground, at}, {*mesh, far}));
  EXPECT_FALSE(ExactLowerBound_m({*mesh, at}, {*ball, at}));
  EXPECT_TRUE(ExactLowerBound_m({*mesh, at}, {*ball, far}));
}

}  // namespace
}  // namespace cwm::collision
