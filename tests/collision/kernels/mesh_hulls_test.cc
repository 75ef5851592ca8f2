// Answers from hulls of meshes must equal those from the triangles, however near the meshes are.
#include "collision/kernels/mesh_hulls.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "collision/geometry/support.h"
#include "collision/geometry/tessellate.h"
#include "collision/kernels/convex_pair.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/exact_geometry.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

constexpr double kSize_m = 0.2;  // size of the shapes, as of a link

// Moves each vertex towards the origin by up to a share of its distance.
TriangleMesh Dented(TriangleMesh mesh, double share, RandomPairs& random) {
  for (Vector3& vertex : mesh.vertices) vertex *= 1 - random.Uniform(0, share);
  return mesh;
}

TriangleMesh Turned(TriangleMesh mesh) {
  for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// Both surfaces as one mesh.
TriangleMesh Joined(TriangleMesh a, const TriangleMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) {
    a.triangles.push_back({first + i, first + j, first + k});
  }
  return a;
}

Mesh Closed(TriangleMesh mesh) {
  EXPECT_TRUE(IsWatertight(mesh));
  return {std::make_shared<const TriangleMesh>(std::move(mesh)), true};
}

Mesh HollowBall() {
  return Closed(Joined(Tessellate(Sphere{0.5 * kSize_m}, 1e-3),
                       Turned(Tessellate(Sphere{0.4 * kSize_m}, 1e-3))));
}

std::vector<Mesh> SomeMeshes(RandomPairs& random) {
  std::vector<Mesh> meshes;
  const TriangleMesh ball = Tessellate(Sphere{0.5 * kSize_m}, 1e-3);
  const TriangleMesh can = Tessellate(Cylinder{0.25 * kSize_m, kSize_m}, 1e-4);
  meshes.push_back(Closed(ball));
  meshes.push_back(Closed(can));
  meshes.push_back(Closed(Tessellate(Box{{kSize_m, 0.4 * kSize_m, 0.7 * kSize_m}}, 1e-3)));
  meshes.push_back(Closed(Dented(ball, 0.01, random)));
  meshes.push_back(Closed(Dented(can, 0.2, random)));
  meshes.push_back(Closed(Turned(can)));  // as solid as its mirror image
  meshes.push_back(HollowBall());
  Mesh open = meshes[3];
  open.watertight = false;
  meshes.push_back(open);
  return meshes;
}

TEST(MeshHulls, LieAroundAndWithinTheMesh) {
  RandomPairs random(51);
  int within = 0;
  for (const Mesh& mesh : SomeMeshes(random)) {
    const TriangleTree tree(*mesh.mesh);
    const auto hulls = MeshHulls::Make(mesh, tree);
    ASSERT_NE(hulls, nullptr);
    for (const Vector3& vertex : mesh.mesh->vertices) {
      const ConvexCore point = CoreOf(std::span(&vertex, 1));
      const PairDistance off =
          IterativeConvexDistance(hulls->outer_hull(), point, Pose::Identity(), 1);
      EXPECT_LE(off.distance_m, 1e-9 * kSize_m);
    }
    if (hulls->inner_hull() == nullptr) continue;
    ++within;
    EXPECT_TRUE(mesh.watertight);
    EXPECT_TRUE(tree.Contains(hulls->inner_hull()->centre));
    for (const TriangleCorners& triangle : tree.triangles()) {
      const ConvexCore core = CoreOf(std::span<const Vector3>(triangle.corners));
      EXPECT_FALSE(ConvexOverlap(*hulls->inner_hull(), core, Pose::Identity()));
    }
  }
  EXPECT_EQ(within, 6);  // neither the hollow ball nor the open one
}

struct Tally {
  int by_hulls = 0, by_corner = 0, not_by_corner = 0, by_faces = 0, overlapping = 0, apart = 0;
};

bool FacePartsOnlyWhatIsApart(const BoxedMesh& a, const BoxedMesh& b, const Pose& X_AB,
                              bool overlap) {
  const bool parts = BoxFaceSeparates(a, b, X_AB);
  EXPECT_FALSE(parts && overlap);
  return parts;
}

// The expected answer is the sign of the distance without a limit, which comes from the triangles.
void ExpectThePlainAnswer(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                          Tally& result) {
  const Pose I = Pose::Identity();
  const bool plain = ExactDistance({a, I}, {b, X_AB}).distance_m < 0;
  EXPECT_EQ(ExactOverlap({a, I}, {b, X_AB}), plain);
  EXPECT_EQ(ExactOverlap({b, X_AB}, {a, I}), plain);
  ++(plain ? result.overlapping : result.apart);
  const auto by_hulls = b.hulls() != nullptr ? HullsOverlap(*a.hulls(), *b.hulls(), X_AB)
                                             : HullsOverlap(*a.hulls(), b.pieces().front(), X_AB);
  if (b.hulls() != nullptr) {
    result.by_faces += FacePartsOnlyWhatIsApart({*a.hulls(), a.tree()->bounds()},
                                                {*b.hulls(), b.tree()->bounds()}, X_AB, plain)
                           ? 1
                           : 0;
  } else {
    const Pose X_BA = X_AB.inverse();
    const CentredMesh middle{*a.hulls(), X_BA * a.tree()->bounds().center()};
    const auto by_corner = QuickOverlap(middle, b.pieces().front(), X_AB, X_BA);
    EXPECT_EQ(by_corner.value_or(plain), plain);
    ++(by_corner ? result.by_corner : result.not_by_corner);
  }
  if (!by_hulls) return;
  EXPECT_EQ(*by_hulls, plain);
  ++result.by_hulls;
}

TEST(MeshHulls, TellWhatTheTrianglesTell) {
  constexpr int kPairs = 30;  // with each of the others
  constexpr std::array kOffsets_m = {5e-3, 1e-3, 1e-4, 1e-5, 1e-7};
  RandomPairs random(52);
  const std::vector<Mesh> meshes = SomeMeshes(random);
  std::vector<Shape> others(meshes.begin(), meshes.end());
  others.push_back(Box{{kSize_m, 0.1 * kSize_m, kSize_m}});
  others.push_back(Cylinder{0.1 * kSize_m, kSize_m});
  others.push_back(Capsule{0.1 * kSize_m, kSize_m});
  others.push_back(Cone{0.3 * kSize_m, 0.1 * kSize_m, kSize_m});
  for (const Mesh& mesh : meshes) {
    const ExactGeometry a(mesh);
    Tally result;
    for (const Shape& other : others) {
      const ExactGeometry b(other);
      for (int k = 0; k < kPairs; ++k) {
        Pose X_AB = random.AnyPose(1.6 * kSize_m);
        ExpectThePlainAnswer(a, b, X_AB, result);
        // Again, with less than five millimetres between them or a small overlap.
        const PairDistance answer = ExactDistance({a, Pose::Identity()}, {b, X_AB});
        const double offset_m = kOffsets_m[static_cast<std::size_t>(k) % kOffsets_m.size()];
        X_AB.translation() -=
            (answer.distance_m + (k % 2 == 0 ? offset_m : -offset_m)) * answer.normal;
        ExpectThePlainAnswer(a, b, X_AB, result);
      }
    }
    EXPECT_GT(result.by_hulls, (result.overlapping + result.apart) / 4);
    EXPECT_GT(result.by_corner, result.not_by_corner / 4);
    EXPECT_GT(result.by_faces, result.apart / 10);
    EXPECT_GT(result.overlapping, result.apart / 3);
    EXPECT_GT(result.apart, result.overlapping / 3);
  }
}

TEST(MeshHulls, HaveNoCornerThatNoTriangleHas) {
  TriangleMesh mesh = Tessellate(Box{Vector3::Constant(kSize_m)}, 1e-3);
  const ExactGeometry plain(Closed(mesh));
  mesh.vertices.emplace_back(5 * kSize_m, 0, 0);
  const ExactGeometry more(Closed(mesh)), box(Box{Vector3::Constant(kSize_m)});
  EXPECT_EQ(more.hulls()->outer_hull().extent_m, plain.hulls()->outer_hull().extent_m);
  const Pose I = Pose::Identity();
  EXPECT_FALSE(ExactOverlap({more, I}, {box, MakeTranslation(5 * kSize_m, 0, 0)}));
}

TEST(MeshHulls, LeaveTheNearestTrianglesToTheSearch) {
  RandomPairs random(54);
  const TriangleMesh can = Tessellate(Cylinder{0.25 * kSize_m, kSize_m}, 2e-3);
  const ExactGeometry a(Closed(Dented(can, 0.05, random))), b(Closed(Dented(can, 0.2, random)));
  const Pose I = Pose::Identity();
  int apart = 0;
  for (int k = 0; k < 60; ++k) {
    const Pose X_AB = random.AnyPose(1.5 * kSize_m);
    const PairDistance result = ExactDistance({a, I}, {b, X_AB});
    if (result.distance_m < 0) continue;
    ++apart;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const TriangleCorners& mine : a.tree()->triangles()) {
      for (const TriangleCorners& theirs : b.tree()->triangles()) {
        const double distance_m =
            IterativeConvexDistance(CoreOf(std::span<const Vector3>(mine.corners)),
                                    CoreOf(std::span<const Vector3>(theirs.corners)), X_AB,
                                    nearest_m)
                .distance_m;
        nearest_m = std::min(nearest_m, distance_m);
      }
    }
    EXPECT_NEAR(result.distance_m, nearest_m, 1e-9 * kSize_m);
    EXPECT_NEAR((result.point_b - result.point_a).norm(), nearest_m, 1e-9 * kSize_m);
    const double below_m = 0.999 * nearest_m, above_m = 1.001 * nearest_m;
    EXPECT_GT(ExactDistance({a, I}, {b, X_AB}, below_m).distance_m, below_m);
    EXPECT_EQ(ExactDistance({a, I}, {b, X_AB}, above_m).distance_m, result.distance_m);
  }
  EXPECT_GT(apart, 20);
}

TEST(MeshHulls, LeaveRoomInACavity) {
  const ExactGeometry hollow(HollowBall());
  const ExactGeometry pebble(Closed(Tessellate(Sphere{0.1 * kSize_m}, 1e-3)));
  const ExactGeometry cube(Box{Vector3::Constant(0.2 * kSize_m)});
  const Pose I = Pose::Identity(), in_wall = MakeTranslation(0.45 * kSize_m, 0, 0);
  for (const ExactGeometry* small : {&pebble, &cube}) {
    EXPECT_FALSE(ExactOverlap({hollow, I}, {*small, I}));
    EXPECT_TRUE(ExactOverlap({hollow, I}, {*small, in_wall}));
  }
}

TEST(VertexLanes, FindWhatAPlainLoopFinds) {
  RandomPairs random(53);
  for (const int count : {1, 2, 15, 16, 17, 31, 152, 153}) {
    std::vector<Vector3> vertices;
    // On a coarse grid, where many vertices are equally far.
    for (int k = 0; k < count; ++k) {
      const int x = random.Index(3), y = random.Index(3), z = random.Index(3);
      vertices.emplace_back(x, y, z);
    }
    const VertexLanes lanes(vertices);
    for (int k = 0; k < 200; ++k) {
      const Vector3 d = k % 2 == 0 ? random.Direction() : Vector3(random.Index(3) - 1, 0, 1);
      EXPECT_EQ(vertices[lanes.Farthest(d)],
                cwm::SupportPoint(std::span<const Vector3>(vertices), d));
    }
    EXPECT_EQ(lanes.Farthest(Vector3::Constant(std::nan(""))), 0U);
    EXPECT_EQ(lanes.Farthest(Vector3::Zero()), 0U);
  }
}

// For vertices in a plane across the direction, the order of the sums decides.
TEST(VertexLanes, FindWhatAPlainLoopFindsWhereRoundingDecides) {
  RandomPairs random(54);
  for (int k = 0; k < 500; ++k) {
    const Vector3 d = random.Direction();
    std::vector<Vector3> vertices;
    for (int i = 0; i < 40; ++i) {
      const Vector3 v = random.Direction();
      vertices.push_back(v + (1 - v.dot(d)) * d);
    }
    const VertexLanes lanes(vertices);
    EXPECT_EQ(vertices[lanes.Farthest(d)],
              cwm::SupportPoint(std::span<const Vector3>(vertices), d));
  }
}

}  // namespace
}  // namespace cwm::collision
