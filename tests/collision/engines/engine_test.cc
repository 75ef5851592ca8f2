#include "collision/engines/engine.h"

#include <gtest/gtest.h>

#include <thread>

#include "collision/engines/convex_pieces.h"
#include "collision/engines/prepared_shape.h"
#include "collision/engines/solid.h"
#include "collision/geometry/signed_distance.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

TEST(Engine, SupportsIsSymmetric) {
  for (const EngineKind kind : {EngineKind::kExact, EngineKind::kFcl, EngineKind::kBullet}) {
    const Engine& engine = GetEngine(kind);
    EXPECT_EQ(engine.kind(), kind);
    for (int a = 0; a < kShapeKindCount; ++a) {
      for (int b = 0; b < kShapeKindCount; ++b) {
        for (const QueryKind q :
             {QueryKind::kCollides, QueryKind::kDistance, QueryKind::kContacts}) {
          EXPECT_EQ(engine.Supports(ShapeKind(a), ShapeKind(b), q),
                    engine.Supports(ShapeKind(b), ShapeKind(a), q));
        }
      }
    }
  }
}

TEST(Engine, AutoAnswersEveryPair) {
  for (int a = 0; a < kShapeKindCount; ++a) {
    for (int b = 0; b < kShapeKindCount; ++b) {
      for (const QueryKind q : {QueryKind::kCollides, QueryKind::kDistance, QueryKind::kContacts}) {
        EXPECT_NE(BestEngine(ShapeKind(a), ShapeKind(b), q), nullptr);
      }
    }
  }
}

TEST(Engine, PreparesEveryShapeForAll) {
  for (const CatalogueShape& entry : Catalogue()) {
    const PreparedShape prepared = PrepareShape(entry.shape);
    for (int i = 0; i < kEngineCount; ++i) EXPECT_NE(prepared[i], nullptr) << entry.name;
  }
}

TEST(PreparedShape, IsSharedByAllThatReferToOneMeshAndDiesWithThem) {
  const Mesh mesh = MakeMesh(ElbowMesh());
  std::vector<PreparedShape> prepared(4);
  std::vector<std::thread> threads;
  for (PreparedShape& mine : prepared) {
    threads.emplace_back([&mine, &mesh] {
      mine = PrepareShape(mesh);
      for (int i = 0; i < kEngineCount; ++i) ASSERT_NE(mine[i], nullptr);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < kEngineCount; ++i) {
    for (const PreparedShape& other : prepared) EXPECT_EQ(other[i], prepared[0][i]);
  }
  Mesh open = mesh;
  open.watertight = false;  // a different solid
  EXPECT_NE(PrepareShape(open)[0], prepared[0][0]);
  EXPECT_GT(mesh.mesh.use_count(), 2);
  prepared.clear();
  open.mesh.reset();
  EXPECT_EQ(mesh.mesh.use_count(), 1);
}

TEST(ConvexPieces, OfFlatConesAndThinPlatesAreNeverEmpty) {
  for (const Shape& shape :
       {Shape(Cone{1000, 999, 1e-9}), Shape(Plate{{{0, 0}, {1e3, 0}, {0, 1e3}}, {}, 1e-9})}) {
    const PreparedShape flat = PrepareShape(shape);
    const PreparedShape ball = PrepareShape(Sphere{0.1});
    const Pose X_WF = Pose::Identity(), X_WB = MakeTranslation(10, 10, 1);
    for (int i = 0; i < kEngineCount; ++i) {
      const PairDistance answer =
          GetEngine(EngineKind(i))
              .Distance({KindOf(shape), *flat[i], X_WF}, {ShapeKind::kSphere, *ball[i], X_WB}, 100);
      EXPECT_NEAR(answer.distance_m, 0.9, answer.bound_m + 1e-6) << i;
    }
  }
}

TEST(ConvexPieces, ContainATruncatedConeWithinTheirBound) {
  const Cone cup{0.04, 0.07, 0.12};
  const ConvexPieceSet set = CircumscribedPieces(cup);
  ASSERT_EQ(set.hulls.size(), 1u);
  EXPECT_LT(set.bound_m, 1e-4);
  const Convex hull{std::make_shared<const TriangleMesh>(set.hulls[0])};
  for (const Vector3& v : set.hulls[0].vertices) {
    EXPECT_LE(SignedDistance_m(Shape(cup), v), set.bound_m + 1e-12);
  }
  for (int i = 0; i < 360; ++i) {  // the rims are inside the hull
    const double angle = 0.0174532925 * i;
    const Vector3 on_top(0.07 * std::cos(angle), 0.07 * std::sin(angle), 0.06);
    EXPECT_LE(SignedDistance_m(Shape(hull), on_top), 1e-12);
  }
}

TEST(ConvexPieces, CoverAPlateWithAHole) {
  const Plate plate{.outline = {{0, 0}, {2, 0}, {2, 2}, {0, 2}},
                    .holes = {{{0.5, 0.5}, {1.5, 0.5}, {1.5, 1.5}, {0.5, 1.5}}},
                    .thickness_m = 0.1};
  double volume_m3 = 0;
  for (const TriangleMesh& hull : CircumscribedPieces(plate).hulls) {
    volume_m3 += SignedVolume_m3(hull);
  }
  EXPECT_NEAR(volume_m3, (4 - 1) * 0.1, 1e-9);
}

TEST(Solid, ABoxMeshHoldsTheComponentOfAnotherThatLiesInside) {
  // Two separate cubes in one mesh, one inside the large cube and one far away.
  TriangleMesh two = BoxMesh({0.1, 0.1, 0.1});
  const TriangleMesh far = BoxMesh({0.1, 0.1, 0.1});
  const auto offset = static_cast<std::uint32_t>(two.vertices.size());
  for (const Vector3& v : far.vertices) two.vertices.push_back(v + Vector3(9, 0, 0));
  for (auto t : far.triangles)
    two.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  const Solid pair(PrepareExact(MakeMesh(two)));
  const Solid large(PrepareExact(MakeMesh(BoxMesh({1, 1, 1}))));
  const Pose I = Pose::Identity();
  EXPECT_EQ(pair.points().size(), 2u);
  EXPECT_TRUE(EitherContainsOther(pair, I, large, I));
  EXPECT_TRUE(EitherContainsOther(large, I, pair, MakeTranslation(-9, 0, 0)));
  EXPECT_FALSE(EitherContainsOther(large, I, pair, MakeTranslation(-4, 0, 0)));
}

TEST(Solid, ContainsAgreesWithTheSignedDistance) {
  std::mt19937 random(5);
  for (const CatalogueShape& entry : Catalogue()) {
    if (KindOf(entry.shape) == ShapeKind::kHalfSpace) continue;
    const Solid solid(PrepareExact(entry.shape));
    for (int i = 0; i < 300; ++i) {
      const Vector3 p = RandomPose(random, 0.15).translation();
      const double distance_m = SignedDistance_m(entry.shape, p);
      if (std::abs(distance_m) < 1e-9) continue;
      EXPECT_EQ(solid.Contains(p), distance_m < 0) << entry.name;
    }
  }
}

}  // namespace
}  // namespace cwm::collision
