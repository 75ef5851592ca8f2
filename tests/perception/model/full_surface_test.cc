#include "perception/model/full_surface.h"

#include <gtest/gtest.h>

#include "collision/geometry/validation.h"

namespace cwm::perception {
namespace {

constexpr double kDeviation_m = 5e-4;

Mesh OneTriangle(double x) { return MakeMesh({{{x, 0, 0}, {x, 1, 0}, {x, 0, 1}}, {{0, 1, 2}}}); }

TEST(FullSurface, JoinsShapesSurfacesAndHandlesInTheObjectsFrame) {
  HybridModel model;
  const Sphere ball{.radius_m = 0.1};
  model.shapes.push_back({.X_OS = MakeTranslation(1, 2, 3), .shape = ball});
  model.surfaces.push_back({.surface = OneTriangle(5)});
  Handle handle;
  handle.surface = OneTriangle(6);
  model.handles.push_back(handle);
  const TriangleMesh whole = FullSurface(model, kDeviation_m);
  EXPECT_FALSE(FindViolation(whole));
  ASSERT_GT(whole.vertices.size(), 6u);
  const std::size_t of_ball = whole.vertices.size() - 6;
  for (std::size_t i = 0; i < of_ball; ++i) {
    EXPECT_NEAR((whole.vertices[i] - Vector3(1, 2, 3)).norm(), ball.radius_m, 1e-9);
  }
  const std::size_t last = whole.triangles.size() - 1;
  EXPECT_EQ(whole.vertices[whole.triangles[last - 1][0]].x(), 5);
  EXPECT_EQ(whole.vertices[whole.triangles[last][0]].x(), 6);
}

TEST(FullSurface, OfNoPartsIsEmpty) { EXPECT_TRUE(FullSurface(HybridModel()).vertices.empty()); }

}  // namespace
}  // namespace cwm::perception
