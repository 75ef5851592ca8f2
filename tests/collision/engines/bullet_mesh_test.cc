#include <gtest/gtest.h>

#include "collision/engines/bullet_geometry.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

TEST(BulletMesh, OfSeveralPartsHasEveryTriangleOnce) {
  const Mesh mesh = MakeMesh(ElbowMesh());
  const auto whole = MakeBulletMesh(mesh.mesh), parts = MakeBulletMesh(mesh.mesh, 3);
  EXPECT_EQ(whole->arrays->getNumSubParts(), 1);
  EXPECT_EQ(parts->arrays->getNumSubParts(), static_cast<int>(mesh.mesh->triangles.size() + 2) / 3);
  struct Corners final : btTriangleCallback {
    void processTriangle(btVector3* corners, int, int) override {
      for (int i = 0; i < 3; ++i) sum += FromBullet(corners[i]);
      ++count;
    }
    Vector3 sum = Vector3::Zero();
    int count = 0;
  };
  Corners all, split;
  const btVector3 far(9, 9, 9);
  whole->shape->processAllTriangles(&all, -far, far);
  parts->shape->processAllTriangles(&split, -far, far);
  EXPECT_EQ(all.count, static_cast<int>(mesh.mesh->triangles.size()));
  EXPECT_EQ(split.count, all.count);
  EXPECT_LT((split.sum - all.sum).norm(), 1e-12);
}

}  // namespace
}  // namespace cwm::collision
