#include "tests/contract/catalogue.h"

#include <algorithm>

#include "collision/geometry/tessellate.h"

namespace cwm::collision {
namespace {

Plate FrameOfATable() {
  return {.outline = {{-0.2, -0.15}, {0.2, -0.15}, {0.2, 0}, {0.05, 0.15}, {-0.2, 0.15}},
          .holes = {{{-0.1, -0.05}, {0, -0.05}, {0, 0.05}, {-0.1, 0.05}}},
          .thickness_m = 0.03};
}

TriangleMesh OpenTop() {  // a box without its lid
  TriangleMesh mesh = BoxMesh({0.2, 0.16, 0.12});
  std::erase_if(mesh.triangles, [&](const TriangleMesh::Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](auto v) { return mesh.vertices[v].z() > 0; });
  });
  return mesh;
}

Convex Wedge() {
  return {std::make_shared<const TriangleMesh>(ConvexHull3({{-0.1, -0.08, -0.05},
                                                            {0.1, -0.08, -0.05},
                                                            {-0.1, 0.08, -0.05},
                                                            {0.1, 0.08, -0.05},
                                                            {-0.1, -0.03, 0.09},
                                                            {0.07, 0.02, 0.1}}))};
}

}  // namespace

TriangleMesh BoxMesh(const Vector3& size_m) { return Tessellate(Box{size_m}); }

TriangleMesh ElbowMesh() {
  return Tessellate(Plate{
      .outline =
          {{-0.1, -0.1}, {0.1, -0.1}, {0.1, -0.02}, {-0.02, -0.02}, {-0.02, 0.1}, {-0.1, 0.1}},
      .holes = {},
      .thickness_m = 0.1});
}

const std::vector<CatalogueShape>& Catalogue() {
  static const auto* catalogue = new std::vector<CatalogueShape>{
      {"Sphere", Sphere{0.09}, 0.09},
      {"Box", Box{{0.2, 0.12, 0.08}}, 0.1},
      {"Cylinder", Cylinder{0.05, 0.2}, 0.1},
      {"PointedCone", Cone{0.08, 0, 0.2}, 0.09},
      {"InvertedCone", Cone{0, 0.08, 0.2}, 0.09},
      {"Cup", Cone{0.04, 0.07, 0.12}, 0.08},
      {"Capsule", Capsule{0.04, 0.15}, 0.09},
      {"HalfSpace", HalfSpace{}, 0.1},
      {"Plate", FrameOfATable(), 0.2},
      {"Convex", Wedge(), 0.1},
      {"ClosedMesh", MakeMesh(ElbowMesh()), 0.1},
      {"OpenMesh", MakeMesh(OpenTop()), 0.1},
  };
  return *catalogue;
}

Pose RandomPose(std::mt19937& random, double spread_m) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-spread_m, spread_m);
  const Quaternion q(normal(random), normal(random), normal(random), normal(random));
  return MakePose({place(random), place(random), place(random)}, q.normalized());
}

}  // namespace cwm::collision
