// How much the depth of an overlap with a mesh leaves open.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "collision/mesh_files/mesh_file.h"
#include "tests/collision/kernels/random_pairs.h"
#include "tests/support/outside_data.h"

namespace cwm::collision {
namespace {

constexpr double kTolerance_m = kExactTolerance_m;  // of depths that count as exact

PairDistance Solve(const Shape& a, const Pose& X_FA, const Shape& b, const Pose& X_FB) {
  const auto exact_a = PrepareExact(a), exact_b = PrepareExact(b);
  return ExactDistance({*exact_a, X_FA}, {*exact_b, X_FB});
}

// A pose within a box of this size about the origin.
Pose PoseWithin(const Vector3& size_m, RandomPairs& random) {
  Pose X_FB = Pose::Identity();
  X_FB.linear() = random.Rotation();
  for (int k = 0; k < 3; ++k) X_FB.translation()[k] = random.Uniform(-0.5, 0.5) * size_m[k];
  return X_FB;
}

Shape SmallShape(int k) {
  const Shape shapes[] = {Box{{0.06, 0.06, 0.06}}, Sphere{0.03}, Capsule{0.01, 0.05},
                          Cylinder{0.02, 0.05}};
  return shapes[k % 4];
}

TEST(DepthBound, OfABoxAsAMeshIsAMicrometreAtMost) {
  const Box box{{0.2, 0.3, 0.4}};
  const Mesh mesh = MakeMesh(Tessellate(box));
  const Pose here = Pose::Identity(), beside = MakeTranslation(0.02, 0, 0);
  const PairDistance inside = Solve(mesh, here, Box{{0.06, 0.06, 0.06}}, beside);
  EXPECT_NEAR(inside.distance_m, -(0.1 - 0.02 + 0.03), 1e-6);
  EXPECT_LE(inside.bound_m, 1e-6);
  RandomPairs random(5);
  double largest_m = 0;
  for (int k = 0; k < 400; ++k) {
    const Pose X_FB = PoseWithin(box.size_m, random);
    const Shape shape = SmallShape(k);
    const PairDistance solid = Solve(box, here, shape, X_FB);
    const PairDistance answer = Solve(mesh, here, shape, X_FB);
    EXPECT_GE(answer.distance_m, solid.distance_m - kTolerance_m) << k;
    EXPECT_LE(answer.distance_m - answer.bound_m, solid.distance_m + kTolerance_m) << k;
    largest_m = std::max(largest_m, answer.bound_m);
  }
  EXPECT_LE(largest_m, 1e-6);
}

TEST(DepthBound, OfTwoBoxesAsMeshesIsAMicrometreAtMost) {
  const Box a{{0.2, 0.3, 0.4}}, b{{0.1, 0.05, 0.2}};
  const Mesh mesh_a = MakeMesh(Tessellate(a)), mesh_b = MakeMesh(Tessellate(b));
  RandomPairs random(6);
  double largest_m = 0;
  for (int k = 0; k < 100; ++k) {
    const Pose here = Pose::Identity(), X_FB = PoseWithin(a.size_m, random);
    const PairDistance solid = Solve(a, here, b, X_FB);
    const PairDistance answer = Solve(mesh_a, here, mesh_b, X_FB);
    EXPECT_GE(answer.distance_m, solid.distance_m - kTolerance_m) << k;
    EXPECT_LE(answer.distance_m - answer.bound_m, solid.distance_m + kTolerance_m) << k;
    largest_m = std::max(largest_m, answer.bound_m);
  }
  EXPECT_LE(largest_m, 1e-6);
}

TEST(DepthBound, OfThePandasHandIsAFifthOfAMillimetreAtMost) {
  const auto file = testing::OutsideData("motion_bench_maker/panda/meshes/collision/hand.obj");
  if (!file) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
  std::ostringstream bytes;
  bytes << std::ifstream(*file, std::ios::binary).rdbuf();
  const auto read = ReadMeshFile(bytes.str(), *file);
  ASSERT_TRUE(read.ok()) << read.status();
  const Mesh hand = MakeMesh(*read);
  ASSERT_TRUE(hand.watertight);
  const Convex hull{std::make_shared<const TriangleMesh>(ConvexHull3(read->vertices))};
  Eigen::AlignedBox3d bounds;
  for (const Vector3& p : read->vertices) bounds.extend(p);
  RandomPairs random(7);
  double largest_m = 0;
  for (int k = 0; k < 400; ++k) {
    Pose X_FB = PoseWithin(bounds.sizes(), random);
    X_FB.translation() += bounds.center();
    const Shape shape = SmallShape(k);
    // The hull contains the hand, so that it is at least as deep.
    const PairDistance around = Solve(hull, Pose::Identity(), shape, X_FB);
    const PairDistance answer = Solve(hand, Pose::Identity(), shape, X_FB);
    if (answer.distance_m >= 0) continue;
    EXPECT_GE(answer.distance_m, around.distance_m - kTolerance_m) << k;
    EXPECT_LE(answer.distance_m - answer.bound_m, around.distance_m + kTolerance_m) << k;
    largest_m = std::max(largest_m, answer.bound_m);
  }
  EXPECT_GT(largest_m, 0);
  EXPECT_LE(largest_m, 0.2e-3);
}

}  // namespace
}  // namespace cwm::collision
