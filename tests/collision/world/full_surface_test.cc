#include "collision/world/full_surface.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collision/geometry/signed_distance.h"

namespace cwm::collision {
namespace {

constexpr std::size_t kPlenty = 5'000'000;
constexpr double kRounding_m = 1e-12;

TriangleMesh Flag() {
  return {.vertices = {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}}, .triangles = {{0, 1, 2}}};
}

std::shared_ptr<const PreparedModel> ModelOf(std::vector<Placed<Shape>> shapes) {
  auto model = std::make_shared<HybridModel>();
  for (Placed<Shape>& placed : shapes) {
    model->shapes.push_back({.X_OS = placed.X_FS, .shape = std::move(placed.shape)});
  }
  return Prepare(std::move(model));
}

// A mug: a cup, a measured surface, a handle with a mesh, and a handle without one.
std::shared_ptr<const PreparedModel> Mug() {
  auto model = std::make_shared<HybridModel>();
  const Pose tilted(Eigen::AngleAxisd(0.3, Vector3::UnitX()));
  model->shapes.push_back(
      {.X_OS = MakeTranslation(0, 0, 0.05) * tilted, .shape = Cylinder{0.04, 0.1}});
  model->surfaces.push_back({.surface = MakeMesh(Flag()), .point_count = 3});
  model->handles.push_back({.bounds = {}, .surface = MakeMesh(Flag())});
  model->handles.push_back(
      {.bounds = {.X_FS = MakeTranslation(0.06, 0, 0.05), .shape = Box{{0.02, 0.01, 0.06}}},
       .surface = {}});
  return Prepare(std::move(model));
}

TEST(FullSurface, HoldsShapesSurfacesAndHandlesEachWithItsOwnVertices) {
  const auto surface = FullSurfaceOf(*Mug(), kPlenty);
  ASSERT_TRUE(surface.has_value());
  const TriangleMesh cup = Tessellate(Cylinder{0.04, 0.1});
  const TriangleMesh& mesh = surface->mesh_O;
  EXPECT_EQ(mesh.vertices.size(), cup.vertices.size() + 3 + 3 + 8);
  EXPECT_EQ(mesh.triangles.size(), cup.triangles.size() + 1 + 1 + 12);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.vertices.size());
  }
  // The last part is the handle without a mesh: its bounding box, in the object's frame.
  Aabb handle_O;
  for (std::size_t i = mesh.vertices.size() - 8; i < mesh.vertices.size(); ++i) {
    handle_O.extend(mesh.vertices[i]);
  }
  EXPECT_TRUE(handle_O.min().isApprox(Vector3(0.05, -0.005, 0.02), kRounding_m));
  EXPECT_TRUE(handle_O.max().isApprox(Vector3(0.07, 0.005, 0.08), kRounding_m));
}

TEST(FullSurface, LiesOnItsPartsWithinTheDeviationThatItStates) {
  const Placed<Shape> ball{MakeTranslation(1, 2, 3), Sphere{0.3}};
  const Placed<Shape> dome{MakeTranslation(-9, 0, 0), Sphere{20}};  // beyond kMaxSegments
  for (const auto& [X_FS, shape] : {ball, dome}) {
    const auto surface = FullSurfaceOf(*ModelOf({{X_FS, shape}}), kPlenty);
    ASSERT_TRUE(surface.has_value());
    double deepest_m = 0;
    for (const auto& [a, b, c] : surface->mesh_O.triangles) {
      const auto& p = surface->mesh_O.vertices;
      for (const Vector3& point : {Vector3((p[a] + p[b] + p[c]) / 3), Vector3((p[a] + p[b]) / 2)}) {
        deepest_m = std::max(deepest_m, -SignedDistance_m(shape, X_FS.inverse() * point));
      }
    }
    EXPECT_LE(deepest_m, surface->max_deviation_m);
    EXPECT_GE(deepest_m, 0.5 * surface->max_deviation_m) << "the bound says something";
  }
}

TEST(FullSurface, StatesHalfAMillimetreWhereItCanAndTheLargerTruthWhereItCannot) {
  EXPECT_EQ(FullSurfaceOf(*ModelOf({{Pose::Identity(), Box{{1, 1, 1}}}}), kPlenty)->max_deviation_m,
            0);
  const auto cup = FullSurfaceOf(*Mug(), kPlenty);
  EXPECT_GT(cup->max_deviation_m, 0);
  EXPECT_LE(cup->max_deviation_m, kDefaultDeviation_m);
  const auto silo = FullSurfaceOf(*ModelOf({{Pose::Identity(), Cylinder{20, 5}}}), kPlenty);
  EXPECT_DOUBLE_EQ(silo->max_deviation_m,
                   20 * (1 - std::cos(std::numbers::pi / kMaxSegments)));  // 1.5 mm
}

TEST(FullSurface, OfManyRoundPartsIsCoarserInsteadOfTooLarge) {
  std::vector<Placed<Shape>> balls;
  for (int i = 0; i < 100; ++i) balls.push_back({MakeTranslation(i, 0, 0), Sphere{0.4}});
  const auto model = ModelOf(balls);
  const auto fine = FullSurfaceOf(*model, kPlenty);
  ASSERT_TRUE(fine.has_value());
  const std::size_t max_triangles = fine->mesh_O.triangles.size() / 3;
  const auto coarse = FullSurfaceOf(*model, max_triangles);
  ASSERT_TRUE(coarse.has_value());
  EXPECT_LE(coarse->mesh_O.triangles.size(), max_triangles);
  EXPECT_GT(coarse->max_deviation_m, kDefaultDeviation_m);
  EXPECT_LE(coarse->max_deviation_m, 4 * kDefaultDeviation_m);
  EXPECT_FALSE(FullSurfaceOf(*model, 100).has_value()) << "fewer than one triangle a ball";
}

TEST(FullSurface, OfMeshesAloneIsWholeOrNothing) {
  const auto two =
      ModelOf({{Pose::Identity(), MakeMesh(Flag())}, {MakeTranslation(0, 0, 1), MakeMesh(Flag())}});
  const auto surface = FullSurfaceOf(*two, 2);
  ASSERT_TRUE(surface.has_value());
  EXPECT_EQ(surface->mesh_O.vertices[3], Vector3(0, 0, 3));
  EXPECT_FALSE(FullSurfaceOf(*two, 1).has_value());
}

TEST(FullSurface, HasNoBoundWhereAPartIsAHalfSpace) {
  EXPECT_TRUE(IsBounded(*Mug()));
  EXPECT_FALSE(
      IsBounded(*ModelOf({{Pose::Identity(), Sphere{1}}, {Pose::Identity(), HalfSpace{}}})));
}

}  // namespace
}  // namespace cwm::collision
