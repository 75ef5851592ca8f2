#include "collision/geometry/vessel_shell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/geometry/distance_to_shape.h"

namespace cwm {
namespace {

// A mug of 80 mm with a wall of 4 mm and a floor of 6 mm.
VesselShell Mug() {
  return {.outer = {{0.035, -0.04}, {0.04, 0.04}},
          .inner = {{0.036, 0.04}, {0.031, -0.034}, {0, -0.034}},
          .wall_thickness_m = 0.004};
}

TEST(VesselShell, TellsItsDimensions) {
  const VesselShell mug = Mug();
  EXPECT_EQ(mug.rim_radius_m(), 0.04);
  EXPECT_EQ(mug.foot_radius_m(), 0.035);
  EXPECT_NEAR(mug.height_m(), 0.08, 1e-15);
  EXPECT_NEAR(mug.depth_m(), 0.074, 1e-15);
}

TEST(VesselShell, IsSolidInItsWallAndFloorAndFreeInside) {
  const VesselShell mug = Mug();
  EXPECT_NEAR(SignedDistance_m(mug, {0, 0, 0.05}), std::hypot(0.036, 0.01), 1e-12);  // above
  EXPECT_NEAR(SignedDistance_m(mug, {0, 0, -0.034}), 0, 1e-12);                      // on the floor
  EXPECT_NEAR(SignedDistance_m(mug, {0, 0, -0.037}), -0.003, 1e-12);                 // within it
  EXPECT_NEAR(SignedDistance_m(mug, {0, 0, -0.05}), 0.01, 1e-12);    // below the foot
  EXPECT_NEAR(SignedDistance_m(mug, {0, 0.05, 0.04}), 0.01, 1e-12);  // beside the rim
  EXPECT_GT(SignedDistance_m(mug, {0, 0.01, 0}), 0.02);
  EXPECT_LT(SignedDistance_m(mug, {0.038, 0, 0.039}), 0);
  EXPECT_NEAR(SignedDistance_m(mug, {-0.038, 0, 0.0385}), -0.0015, 2e-4);
}

TEST(VesselShell, MeshIsWatertightAndFollowsTheProfile) {
  const VesselShell mug = Mug();
  constexpr double kDeviation_m = 3e-4;
  const TriangleMesh mesh = Tessellate(mug, kDeviation_m);
  EXPECT_TRUE(IsWatertight(mesh));
  EXPECT_GT(SignedVolume_m3(mesh), 0);
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    const Vector3 middle = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
    EXPECT_LE(std::abs(SignedDistance_m(mug, middle)), kDeviation_m);
  }
}

TEST(VesselShell, PartsAnswerByTheProfileWhatTheirMeshAnswers) {
  constexpr double kDeviation_m = 1e-4;
  const auto mug = std::make_shared<const VesselShell>(Mug());
  const ShapePart part{.shape = MakeMesh(Tessellate(*mug, kDeviation_m)), .vessel = mug};
  const DistanceToShape distance_m(part);
  const DistanceToShape to_mesh_m(part.shape);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(-0.06, 0.06);
  for (int k = 0; k < 200; ++k) {
    const Vector3 p(place(random), place(random), place(random));
    EXPECT_EQ(distance_m(p), SignedDistance_m(part, p));
    EXPECT_NEAR(distance_m(p), to_mesh_m(p), 2 * kDeviation_m);
  }
}

}  // namespace
}  // namespace cwm
