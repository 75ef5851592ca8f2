// Vessels that lie or lean become shells, as upright ones do, if the sensor looks into them.
#include "perception/vessels/lying_vessel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>

#include "perception/modeler/object_modeler.h"
#include "tests/perception/model/surfaces.h"
#include "tests/perception/model/tilted_vessels.h"

namespace cwm::perception {
namespace {

constexpr double kDistance_m = 0.75;
constexpr double kElevation_rad = 40 * kDegree_rad;

struct Lying {
  std::string name;
  VesselWall wall;
  double tilt_deg = 0, yaw_deg = 0;
  double axis_deg = 0;  // tolerance: how well its depth and its visible part determine the axis
};

void PrintTo(const Lying& lying, std::ostream* out) { *out << lying.name; }

class LyingVessel : public ::testing::TestWithParam<Lying> {};

TEST_P(LyingVessel, IsAShellAboutItsAxis) {
  const Lying& lying = GetParam();
  const SimulatedObject truth = TiltedVessel(lying.wall, lying.tilt_deg, lying.yaw_deg);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ScannedObject scan = ScanOnTable(truth, kDistance_m, kElevation_rad, seed);
    const ObjectModel model =
        ModelObject(scan.points, scan.X_WSupport, SensorNoise(), ModelerOptions());
    ASSERT_EQ(model.shapes.size(), 1u) << seed;
    const ShapePart& part = model.shapes[0];
    ASSERT_TRUE(part.vessel) << seed;
    EXPECT_EQ(part.role, PartRole::kFitted);
    // Edges are ragged by the lateral noise, 1.1 mm on either side.
    EXPECT_NEAR(part.vessel->rim_radius_m(), lying.wall.outer.back().radius_m, 0.003) << seed;
    EXPECT_NEAR(part.vessel->height_m(), lying.wall.outer.back().height_m, 0.006) << seed;
    EXPECT_LT(AngleBetween_deg(part.X_OS.linear().col(2), truth.X_WO.linear().col(2)),
              lying.axis_deg)
        << seed;
    // The mouth is free, the floor is not.
    const double half_m = 0.5 * part.vessel->height_m();
    const Vector3 rim = part.X_OS * Vector3(0, 0, half_m);
    EXPECT_GT(SignedDistance_m(part.shape, part.X_OS.inverse() * rim), 0.02);
    EXPECT_LT(SignedDistance_m(*part.vessel, {0, 0, -half_m + 0.001}), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LyingVessel,
                         ::testing::Values(Lying{"MugOnItsSide", MugWall(), 90, 150, 3},
                                           Lying{"MugSeenAskew", MugWall(), 90, 120, 3},
                                           Lying{"LeaningMug", MugWall(), 40, 120, 3},
                                           Lying{"GlassOnItsSide", GlassWall(), 90, 150, 3},
                                           Lying{"PanOnEdge", PanWall(), 90, 150, 3},
                                           Lying{"LeaningPan", PanWall(), 15, 0, 3},
                                           Lying{"BowlOnEdge", BowlWall(), 90, 180, 3},
                                           Lying{"LeaningBowl", BowlWall(), 40, 150, 4}),
                         [](const auto& named) { return named.param.name; });

TEST(FindLyingWall, IsNoneOfWhatStands) {
  for (const VesselWall& wall : {MugWall(), PanWall(), BowlWall()}) {
    const ScannedObject scan =
        ScanOnTable(TiltedVessel(wall, 0, 0), kDistance_m, kElevation_rad, 1);
    const ObjectModel model =
        ModelObject(scan.points, scan.X_WSupport, SensorNoise(), ModelerOptions());
    ASSERT_EQ(model.shapes.size(), 1u);
    ASSERT_TRUE(model.shapes[0].vessel);
    EXPECT_LT(AngleBetween_deg(model.shapes[0].X_OS.linear().col(2), Vector3::UnitZ()), 1);
  }
}

TEST(FindLyingWall, IsNoneOfALyingCan) {
  SimulatedObject can = OfOnePart(Cylinder{.radius_m = 0.04, .length_m = 0.12}, 0);
  can.X_WO.linear() = Eigen::AngleAxisd(90 * kDegree_rad, Vector3::UnitY()).matrix();
  can.X_WO.translation().z() = 0.04;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ScannedObject scan = ScanOnTable(can, kDistance_m, kElevation_rad, seed);
    const ObjectModel model =
        ModelObject(scan.points, scan.X_WSupport, SensorNoise(), ModelerOptions());
    ASSERT_EQ(model.shapes.size(), 1u);
    EXPECT_FALSE(model.shapes[0].vessel);
    EXPECT_TRUE(std::holds_alternative<Cylinder>(model.shapes[0].shape));
  }
}

// A mouth that is turned away cannot be recognised.
TEST(FindLyingWall, IsNoneOfAMugWhoseMouthIsNotSeen) {
  const ScannedObject scan =
      ScanOnTable(TiltedVessel(MugWall(), 90, 0), kDistance_m, kElevation_rad, 1);
  const ObjectModel model =
      ModelObject(scan.points, scan.X_WSupport, SensorNoise(), ModelerOptions());
  ASSERT_EQ(model.shapes.size(), 1u);
  EXPECT_FALSE(model.shapes[0].vessel);
}

}  // namespace
}  // namespace cwm::perception
