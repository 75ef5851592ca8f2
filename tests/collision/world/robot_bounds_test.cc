// The spheres that contain the links of a prepared robot.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/engines/exact_engine.h"
#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "collision/robot/srdf.h"
#include "collision/robot/urdf.h"
#include "collision/spheres/bounding_spheres.h"
#include "collision/world/world_robot.h"
#include "tests/collision/robot/panda_files.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

constexpr double kRounding_m = 1e-12;

bool IsIn(const std::vector<LinkSphere>& spheres, const Vector3& p) {
  return std::ranges::any_of(spheres, [&](const LinkSphere& sphere) {
    return (p - sphere.center_L).norm() <= sphere.radius_m + kRounding_m;
  });
}

Vector3 RandomPointOf(const TriangleMesh& mesh, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const auto& triangle = mesh.triangles[random() % mesh.triangles.size()];
  double u = share(random), v = share(random);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const Vector3& a = mesh.vertices[triangle[0]];
  return a + u * (mesh.vertices[triangle[1]] - a) + v * (mesh.vertices[triangle[2]] - a);
}

// Samples points of the surface and of the inside; for an open mesh, of its whole box.
void ExpectContained(const Shape& shape, const Pose& X_LP, const TriangleTree* tree,
                     const std::vector<LinkSphere>& spheres, std::mt19937& random) {
  const TriangleMesh surface = Tessellate(shape, 1e-5);
  Aabb box;
  for (const Vector3& p : surface.vertices) box.extend(p);
  const auto* mesh = std::get_if<Mesh>(&shape);
  int outside = 0;
  for (int k = 0; k < 4000; ++k) {
    const Vector3 on = RandomPointOf(surface, random), in = box.sample();
    const bool is_inside =
        mesh == nullptr ? SignedDistance_m(shape, in) < 0 : !mesh->watertight || tree->Contains(in);
    outside += IsIn(spheres, X_LP * on) ? 0 : 1;
    outside += !is_inside || IsIn(spheres, X_LP * in) ? 0 : 1;
  }
  EXPECT_EQ(outside, 0);
}

TEST(FitBoundingSpheres, ContainEveryShapeOfTheCatalogue) {
  std::mt19937 random(3);
  for (const CatalogueShape& entry : Catalogue()) {
    SCOPED_TRACE(entry.name);
    const Pose X_LP = RandomPose(random, 0.5);
    std::optional<TriangleTree> tree;
    if (const auto* mesh = std::get_if<Mesh>(&entry.shape)) tree.emplace(*mesh->mesh);
    const LinkPiece piece{.X_LP = X_LP, .shape = &entry.shape, .tree = tree ? &*tree : nullptr};
    const auto spheres = FitBoundingSpheres({&piece, 1});
    ASSERT_EQ(spheres.has_value(), KindOf(entry.shape) != ShapeKind::kHalfSpace);
    if (!spheres) continue;
    EXPECT_LE(spheres->size(), kMaxSpheres);
    ExpectContained(entry.shape, X_LP, piece.tree, *spheres, random);
  }
}

TEST(FitBoundingSpheres, ContainAMeshOfManyTriangles) {
  std::mt19937 random(4);
  const Shape ball = MakeMesh(Tessellate(Sphere{0.3}, 1e-6));
  const TriangleTree tree(*std::get<Mesh>(ball).mesh);
  ASSERT_GT(tree.triangles().size(), 20000u);
  const LinkPiece piece{.X_LP = MakeTranslation(1, 2, 3), .shape = &ball, .tree = &tree};
  const auto spheres = FitBoundingSpheres({&piece, 1});
  ASSERT_TRUE(spheres.has_value());
  ExpectContained(ball, piece.X_LP, &tree, *spheres, random);
}

class PandaBounds : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto files = testing::ReadPandaFiles();
    if (!files) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
    const RobotDescription description = *ReadUrdf(files->urdf, files->meshes);
    const SemanticDescription semantic = *ReadSrdf(files->srdf, description);
    robot_ = PrepareRobot(*MakeRobotModel(description, &semantic), std::nullopt);
  }

  std::shared_ptr<const RobotGeometry> robot_;
  std::mt19937 random_{5};
};

TEST_F(PandaBounds, SpheresContainItsMeshes) {
  ASSERT_NE(robot_->bounding_spheres, nullptr);
  for (std::size_t k = 0; k < robot_->geometry->parts.size(); ++k) {
    const PreparedPart& part = robot_->geometry->parts[k];
    const auto& spheres =
        robot_->bounding_spheres->links[static_cast<std::size_t>(robot_->link_of_part[k])];
    EXPECT_LE(spheres.size(), kMaxSpheres);
    ExpectContained(part.shape, part.X_OP,
                    TreeOf(*part.engines[static_cast<int>(EngineKind::kExact)]), spheres, random_);
  }
}

}  // namespace
}  // namespace cwm::collision
