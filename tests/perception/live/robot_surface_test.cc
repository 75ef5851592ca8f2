#include "perception/live/robot_surface.h"

#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "tests/perception/live/robot_scene.h"

namespace cwm::perception {
namespace {

// Rounding of floats at the coordinates of these bodies, and of the grid's.
constexpr double kRounding_m = 2e-6;

std::vector<Shape> SomeShapes() {
  return {Sphere{.radius_m = 0.08},
          Box{{0.3, 0.1, 0.02}},
          Cylinder{.radius_m = 0.05, .length_m = 0.3},
          Cone{.radius_bottom_m = 0.06, .radius_top_m = 0.03, .length_m = 0.1},
          Capsule{.radius_m = 0.04, .length_m = 0.2},
          Mesh{MakeMesh(Tessellate(Box{{0.2, 0.2, 0.1}}))}};
}

TEST(LinkSurface, BoundsHoldTheDistanceOfEveryPoint) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-0.25, 0.25);
  for (const Shape& shape : SomeShapes()) {
    const Pose X_LG = RandomPose(random, 0.2);
    const Placed<> placed{X_LG, shape};
    const LinkSurface surface({&placed, 1});
    int bounded = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3 p_G(uniform(random), uniform(random), uniform(random));
      const Eigen::Vector3f p_L = (X_LG * p_G).cast<float>();
      const double truth_m = SignedDistance_m(shape, p_G);
      const DistanceGrid::Bounds bounds = surface.BoundsAt(p_L);
      if (std::isnan(bounds.least_m)) {
        EXPECT_GT(truth_m, 0.05);
        continue;
      }
      ++bounded;
      EXPECT_LE(bounds.least_m, truth_m + kRounding_m);
      EXPECT_GE(bounds.greatest_m, truth_m - kRounding_m);
    }
    EXPECT_GT(bounded, 200);
  }
}

TEST(LinkSurface, PointsAreWithinAMarginAsTheirDistanceSays) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-0.25, 0.25);
  for (const Shape& shape : SomeShapes()) {
    const Placed<> placed{Pose::Identity(), shape};
    const LinkSurface surface({&placed, 1});
    for (const float margin_m : {0.0F, 0.004F, 0.02F, 0.1F}) {
      for (int i = 0; i < 1000; ++i) {
        const Vector3 p(uniform(random), uniform(random), uniform(random));
        const double truth_m = SignedDistance_m(shape, p);
        const double tolerance_m = kRounding_m;
        if (std::abs(truth_m - margin_m) <= tolerance_m) continue;
        EXPECT_EQ(surface.IsWithin(p.cast<float>(), margin_m), truth_m < margin_m)
            << truth_m << " " << margin_m;
        const double distance_m = surface.Distance_m(p.cast<float>(), 0.1);
        if (truth_m > 0.1 + tolerance_m) {
          EXPECT_EQ(distance_m, std::numeric_limits<double>::infinity());
        } else if (truth_m < 0.1 - tolerance_m) {
          EXPECT_NEAR(distance_m, std::max(truth_m, 0.0), tolerance_m);
        }
      }
    }
  }
}

TEST(LinkSurface, ABallMayBeWithinTheMarginIfOneOfItsPointsIs) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const Shape shape = Box{{0.3, 0.1, 0.02}};
  const Placed<> placed{Pose::Identity(), shape};
  const LinkSurface surface({&placed, 1});
  int beyond = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3 p(uniform(random), uniform(random), uniform(random));
    constexpr float kRadius_m = 0.05F, kMargin_m = 0.03F;
    if (surface.MayBeWithin(p.cast<float>(), kRadius_m, kMargin_m)) continue;
    ++beyond;
    EXPECT_GT(SignedDistance_m(shape, p), kRadius_m + kMargin_m - kRounding_m);
  }
  EXPECT_GT(beyond, 1000);
}

TEST(LinkSurface, AnOpenMeshHasNoInside) {
  TriangleMesh mesh = Tessellate(Box{{0.2, 0.2, 0.2}});
  mesh.triangles.pop_back();
  const Placed<> placed{Pose::Identity(), MakeMesh(mesh)};
  const LinkSurface surface({&placed, 1});
  EXPECT_FALSE(surface.IsWithin({0, 0, 0}, 0.09F));
  EXPECT_TRUE(surface.IsWithin({0, 0, 0}, 0.11F));
}

TEST(LinkSurface, AMeshWoundInwardsIsTheSameSolid) {
  TriangleMesh mesh = Tessellate(Box{{0.2, 0.2, 0.2}});
  for (auto& [a, b, c] : mesh.triangles) std::swap(b, c);
  const Placed<> placed{Pose::Identity(), MakeMesh(mesh)};
  const LinkSurface surface({&placed, 1});
  EXPECT_TRUE(surface.IsWithin({0, 0, 0}, 0));
  EXPECT_FALSE(surface.IsWithin({0.15F, 0, 0}, 0.04F));
  for (const LinkSurface::Triangle& triangle : surface.triangles()) {
    const auto& [a, b, c] = triangle.corners;
    const auto& p = surface.vertices_L();
    EXPECT_GT((p[b] - p[a]).cross(p[c] - p[a]).dot(p[a]), 0);  // away from the centre
  }
}

TEST(LinkSurface, WithoutBoundedGeometryNothingIsNear) {
  const LinkSurface none(std::span<const Placed<>>{});
  EXPECT_TRUE(none.empty());
  EXPECT_FALSE(none.IsWithin({0, 0, 0}, 1));
  EXPECT_FALSE(none.MayBeWithin({0, 0, 0}, 1, 1));
  const Placed<> floor{Pose::Identity(), HalfSpace{}};
  EXPECT_TRUE(LinkSurface({&floor, 1}).empty());
}

TEST(LinkSurface, HoldsFromMillimetresToAHundredMetres) {
  for (const double scale : {0.001, 1.0, 100.0}) {
    const Placed<> placed{MakeTranslation(scale, 0, 0), Box{Vector3::Constant(2 * scale)}};
    const LinkSurface surface({&placed, 1});
    const auto at = [&](double x) { return Eigen::Vector3f(static_cast<float>(x), 0, 0); };
    EXPECT_TRUE(surface.IsWithin(at(scale), 0));
    EXPECT_TRUE(surface.IsWithin(at(2 * scale + 0.019), 0.02F));
    EXPECT_FALSE(surface.IsWithin(at(2 * scale + 0.021), 0.02F));
    EXPECT_FALSE(surface.IsWithin(at(10 * scale + 1), 0.02F));
  }
}

TEST(LinkSurface, AnObjectIsItsShapesSurfacesAndHandles) {
  HybridModel model;
  model.shapes.push_back({.X_OS = MakeTranslation(1, 0, 0), .shape = Sphere{.radius_m = 0.1}});
  const auto mesh_at = [](double x) {
    TriangleMesh mesh = Tessellate(Box{{0.1, 0.1, 0.1}});
    for (Vector3& p : mesh.vertices) p.x() += x;
    return MakeMesh(mesh);
  };
  model.surfaces.push_back({.surface = mesh_at(2)});
  model.handles.emplace_back().surface = mesh_at(3);
  const LinkSurface surface = SurfaceOf(model);
  for (const float x : {1.0F, 2.0F, 3.0F}) EXPECT_TRUE(surface.IsWithin({x, 0, 0}, 0));
  for (const float x : {0.5F, 1.5F, 2.5F}) EXPECT_FALSE(surface.IsWithin({x, 0, 0}, 0.1F));
}

}  // namespace
}  // namespace cwm::perception
