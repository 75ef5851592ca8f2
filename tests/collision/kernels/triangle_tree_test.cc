// The inside of a mesh, and meshes inside meshes.
#include "collision/kernels/triangle_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "collision/geometry/tessellate.h"
#include "collision/geometry/winding.h"

namespace cwm::collision {
namespace {

TriangleMesh BoxAt(double edge_m, const Vector3& centre) {
  TriangleMesh mesh = Tessellate(Box{Vector3::Constant(edge_m)});
  for (Vector3& v : mesh.vertices) v += centre;
  return mesh;
}

TriangleMesh Union(TriangleMesh a, const TriangleMesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles)
    a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

TriangleMesh Inward(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh Unwelded(const TriangleMesh& mesh) {
  TriangleMesh loose;
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (const std::uint32_t v : t) loose.vertices.push_back(mesh.vertices[v]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  return loose;
}

PairDistance Solve(const TriangleMesh& a, const TriangleMesh& b) {
  const auto exact_a = PrepareExact(MakeMesh(a)), exact_b = PrepareExact(MakeMesh(b));
  return ExactDistance({*exact_a, Pose::Identity()}, {*exact_b, Pose::Identity()});
}

TEST(TriangleTree, EnclosesWhatItsSolidHolds) {
  const Plate elbow{.outline = {{-1, -1}, {1, -1}, {1, -0.2}, {-0.2, -0.2}, {-0.2, 1}, {-1, 1}},
                    .holes = {{{-0.8, -0.8}, {-0.4, -0.8}, {-0.4, -0.4}, {-0.8, -0.4}}},
                    .thickness_m = 0.7};
  const TriangleMesh outward = Tessellate(elbow);
  const TriangleTree tree(outward), inward(Inward(outward));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-1.1, 1.1);
  int held = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3 p(place(random), place(random), place(random));
    const bool expected = SignedDistance_m(Shape(elbow), p) < 0;
    ASSERT_EQ(tree.Contains(p), expected) << p.transpose();
    ASSERT_EQ(inward.Contains(p), expected) << p.transpose();
    held += expected ? 1 : 0;
  }
  EXPECT_GT(held, 500);
}

TEST(TriangleTree, EnclosesPointsWhoseRayRunsIntoCornersAndEdges) {
  const TriangleMesh outward = BoxAt(2, Vector3::Zero());
  const TriangleTree tree(outward), inward(Inward(outward));
  const Vector3 along = Vector3(0.5257, 0.2874, 0.8006).normalized();  // as in the source
  for (const Vector3& target : {Vector3(1, 1, 1), Vector3(0.3, 1, 1), Vector3(0, 0, 1)}) {
    const Vector3 inside = target - 0.5 * along, outside = target - 9 * along;
    EXPECT_TRUE(tree.Contains(inside)) << target.transpose();
    EXPECT_TRUE(inward.Contains(inside)) << target.transpose();
    EXPECT_FALSE(tree.Contains(outside));
    EXPECT_FALSE(inward.Contains(outside));
  }
}

TEST(TriangleTree, TakesPartsThatOverlapAsAUnionAndOnesTurnedInwardAsCavities) {
  const TriangleTree overlapping(Union(BoxAt(2, {0, 0, 0}), BoxAt(2, {1, 0, 0})));
  EXPECT_TRUE(overlapping.Contains({0.5, 0.1, 0.2}));
  EXPECT_TRUE(overlapping.Contains({1.7, 0.1, 0.2}));
  const TriangleTree hollow(Union(BoxAt(2, {0, 0, 0}), Inward(BoxAt(1, {0, 0, 0}))));
  EXPECT_FALSE(hollow.Contains({0.1, 0.1, 0.2}));
  EXPECT_TRUE(hollow.Contains({0.1, 0.1, 0.7}));
}

TEST(ComponentPoints, AreOneForEachPartAlsoWithoutSharedVertices) {
  const TriangleMesh two = Union(BoxAt(1, {0, 0, 0}), BoxAt(1, {5, 0, 0}));
  EXPECT_EQ(ComponentPoints(two).size(), 2u);
  EXPECT_EQ(ComponentPoints(Unwelded(two)).size(), 2u);
}

TEST(MeshInMesh, IsFoundWhicheverPartLiesInside) {
  const TriangleMesh room = BoxAt(1, {0, 0, 0});
  const TriangleMesh far = BoxAt(0.1, {-5, 0, 0}), held = BoxAt(0.1, {0.1, 0, 0});
  for (const TriangleMesh& parts : {Union(far, held), Union(held, far)}) {
    for (const TriangleMesh& outer : {room, Inward(room)}) {
      EXPECT_LT(Solve(outer, parts).distance_m, 0);
      EXPECT_LT(Solve(parts, outer).distance_m, 0);
    }
  }
  const PairDistance free = Solve(room, Union(far, BoxAt(0.1, {0.65, 0, 0})));
  EXPECT_NEAR(free.distance_m, 0.1, 1e-9);
  EXPECT_EQ(free.accuracy, Accuracy::kExact);
}

TEST(MeshInMesh, IsFreeInACavity) {
  const TriangleMesh cupboard = Union(BoxAt(2, {0, 0, 0}), Inward(BoxAt(1, {0, 0, 0})));
  EXPECT_NEAR(Solve(cupboard, BoxAt(0.5, {0, 0, 0})).distance_m, 0.25, 1e-9);
}

TEST(SignedDistance, OfAMeshThatIsWoundInwardIsThatOfItsMirrorImage) {
  const Mesh inward = MakeMesh(Inward(BoxAt(2, {0, 0, 0})));
  ASSERT_TRUE(inward.watertight);
  EXPECT_NEAR(SignedDistance_m(Shape(inward), {0.1, 0.2, 0.7}), -0.3, 1e-12);
}

}  // namespace
}  // namespace cwm::collision
