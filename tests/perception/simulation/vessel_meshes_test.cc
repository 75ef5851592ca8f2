#include "perception/simulation/vessel_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/validation.h"
#include "perception/simulation/ray_casting.h"
#include "perception/simulation/vessels.h"

namespace cwm::perception {
namespace {

constexpr double kPi = std::numbers::pi;

// The share of a circle that a regular polygon of n corners on it covers.
double PolygonShare(int corners) { return std::sin(2 * kPi / corners) / (2 * kPi / corners); }

constexpr int kWallSegments = 96;  // as in vessel_meshes.cc
constexpr int kTubeSegments = 16;

double FrustumVolume_m3(double r0, double r1, double height) {
  return kPi * height * (r0 * r0 + r0 * r1 + r1 * r1) / 3;
}

TEST(VesselMesh, HoldsTheVolumeOfItsWallAndFloor) {
  const VesselWall wall{.outer = {{0.04, 0}, {0.05, 0.1}}, .wall_m = 0.003, .floor_m = 0.005};
  const TriangleMesh mesh = MakeVessel(wall);
  ASSERT_TRUE(IsWatertight(mesh));
  EXPECT_FALSE(FindViolation(mesh));
  const double outer = FrustumVolume_m3(0.04, 0.05, 0.1);
  const double inner = FrustumVolume_m3(0.04 + 0.0005 - 0.003, 0.05 - 0.003, 0.095);
  const double expected = PolygonShare(kWallSegments) * (outer - inner);
  EXPECT_NEAR(SignedVolume_m3(mesh), expected, 1e-9 * expected);
}

TEST(VesselMesh, IsOpenAtTheTop) {
  const VesselWall wall{.outer = {{0.04, 0}, {0.05, 0.1}}, .wall_m = 0.003, .floor_m = 0.005};
  const Shape vessel = MakeMesh(MakeVessel(wall));
  EXPECT_GT(SignedDistance_m(vessel, {0, 0, 0.006}), 0);      // above the floor
  EXPECT_GT(SignedDistance_m(vessel, {0, 0, 0.099}), 0);      // in the mouth
  EXPECT_LT(SignedDistance_m(vessel, {0, 0, 0.0025}), 0);     // in the floor
  EXPECT_LT(SignedDistance_m(vessel, {0.0435, 0, 0.05}), 0);  // in the wall
}

TEST(TubeMesh, HoldsTheVolumeOfAStraightTube) {
  const TriangleMesh mesh =
      MakeTube({{.place_xz = {0.1, 0.2}, .half_thickness_m = 0.005, .half_width_m = 0.008},
                {.place_xz = {0.16, 0.28}, .half_thickness_m = 0.005, .half_width_m = 0.008}});
  ASSERT_TRUE(IsWatertight(mesh));
  const double expected = PolygonShare(kTubeSegments) * kPi * 0.005 * 0.008 * 0.1;
  EXPECT_NEAR(SignedVolume_m3(mesh), expected, 1e-9 * expected);
}

TEST(TubeMesh, KeepsItsThicknessInABend) {
  std::vector<TubePoint> points;
  for (int i = 0; i <= 24; ++i) {
    const double angle = kPi * i / 24;
    points.push_back({.place_xz = {0.03 * std::sin(angle), 0.03 * std::cos(angle)},
                      .half_thickness_m = 0.004,
                      .half_width_m = 0.006});
  }
  const TriangleMesh mesh = MakeTube(points);
  ASSERT_TRUE(IsWatertight(mesh));
  // Guldin's rule: section times the path of its centre, here a chain of chords.
  const double way = 24 * 2 * 0.03 * std::sin(kPi / 48);
  const double expected = PolygonShare(kTubeSegments) * kPi * 0.004 * 0.006 * way;
  EXPECT_NEAR(SignedVolume_m3(mesh), expected, 0.005 * expected);  // mitres at the chords' ends
}

class Vessels : public ::testing::TestWithParam<VesselKind> {};

TEST_P(Vessels, AreWatertightPartsWithOneHandleThatStandOnTheirFoot) {
  RandomDraws draws(3, 0);
  for (int i = 0; i < 20; ++i) {
    const SimulatedObject vessel = DrawVessel(GetParam(), draws);
    EXPECT_NEAR(BoundsInWorld(vessel).min().z(), 0, 1e-12) << vessel.name;
    EXPECT_EQ(vessel.RoleOf(0), PieceRole::kBody);
    EXPECT_EQ(std::count(vessel.part_roles.begin(), vessel.part_roles.end(), PieceRole::kHandle),
              1);
    ASSERT_EQ(vessel.parts.size(), vessel.part_roles.size());
    for (const Placed<>& part : vessel.parts) {
      ASSERT_TRUE(std::get<Mesh>(part.shape).watertight) << vessel.name;
      EXPECT_GT(SignedVolume_m3(*std::get<Mesh>(part.shape).mesh), 0) << vessel.name;
    }
  }
}

// The handle's ends are in the wall: no handle or spout shows inside the vessel, and a handle
// neither floats nor is a second body.
TEST_P(Vessels, HaveHandlesAndSpoutsThatGrowOutOfTheWall) {
  RandomDraws draws(4, 0);
  for (int i = 0; i < 3; ++i) {
    const SimulatedObject vessel = DrawVessel(GetParam(), draws);
    const Shape& body = vessel.parts[0].shape;
    for (std::size_t part = 1; part < vessel.parts.size(); ++part) {
      double nearest_m = 1;
      for (const Vector3& p : std::get<Mesh>(vessel.parts[part].shape).mesh->vertices) {
        const double distance_m = SignedDistance_m(body, p);
        nearest_m = std::min(nearest_m, distance_m);
        if (distance_m <= 0) continue;  // in the wall
        // From inside the vessel the way outwards is blocked.
        const Ray outwards{.origin = p, .direction = {p.x(), p.y(), 0}};
        EXPECT_FALSE(CastRay(body, outwards)) << vessel.name << " " << p.transpose();
      }
      EXPECT_LT(nearest_m, 0) << vessel.name;
    }
  }
}

std::string KindName(const ::testing::TestParamInfo<VesselKind>& info) {
  return std::vector<std::string>{"mug", "pan", "jug"}[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(All, Vessels,
                         ::testing::Values(VesselKind::kMug, VesselKind::kPan, VesselKind::kJug),
                         KindName);

}  // namespace
}  // namespace cwm::perception
