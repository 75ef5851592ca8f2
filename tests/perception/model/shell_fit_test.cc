// Open vessels seen by a Kinect become shells; closed objects do not.
#include "perception/vessels/shell_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/geometry/signed_distance.h"
#include "perception/modeler/object_modeler.h"
#include "tests/perception/model/surfaces.h"
#include "tests/perception/model/tilted_vessels.h"

namespace cwm::perception {
namespace {

constexpr double kDistance_m = 0.75;
constexpr double kElevation_rad = 40 * std::numbers::pi / 180;
// Two reported standard deviations of the radius: the slow warp of 1.3 mm and the wall's thickness.
constexpr double kRadius_m = 0.002;
constexpr double kHeight_m = 0.006;  // edges are ragged by the lateral noise, 1.1 mm on either side

ObjectModel Model(const SimulatedObject& object, std::uint64_t seed) {
  const ScannedObject scan = ScanOnTable(object, kDistance_m, kElevation_rad, seed);
  return ModelObject(scan.points, scan.X_WSupport, SensorNoise(), ModelerOptions());
}

const ShapePart* OnlyVessel(const ObjectModel& model) {
  const ShapePart* vessel = nullptr;
  for (const ShapePart& part : model.shapes) {
    if (!part.vessel) continue;
    if (vessel != nullptr) return nullptr;
    vessel = &part;
  }
  return vessel;
}

double ExplainedShare(const ObjectModel& model) {
  const auto explained = std::count_if(model.part_of_point.begin(), model.part_of_point.end(),
                                       [](std::int32_t part) { return part != kUnexplained; });
  return static_cast<double>(explained) / static_cast<double>(model.part_of_point.size());
}

void ExpectShell(const VesselWall& wall, std::uint64_t seed) {
  const ObjectModel model = Model(OfOnePart(MakeMesh(MakeVessel(wall)), 0), seed);
  const ShapePart* part = OnlyVessel(model);
  ASSERT_NE(part, nullptr) << seed;
  EXPECT_EQ(model.shapes.size(), 1u);
  const double height_m = wall.outer.back().height_m, rim_m = wall.outer.back().radius_m;
  EXPECT_NEAR(part->vessel->rim_radius_m(), rim_m, kRadius_m) << seed;
  EXPECT_NEAR(part->vessel->height_m(), height_m, kHeight_m) << seed;
  EXPECT_GT(part->vessel->wall_thickness_m, 0.0015);
  EXPECT_LT(part->vessel->wall_thickness_m, 0.007);
  // The foot is on the table, the axis is where the vessel stands and points up.
  const Pose& X = part->X_OS;
  EXPECT_NEAR(X.translation().head<2>().norm(), 0, 0.003);
  EXPECT_GT(X.linear()(2, 2), 0.998);
  EXPECT_NEAR((X * Vector3(0, 0, part->vessel->outer.front().y())).z(), 0, 0.003);
  // Watertight, free inside, solid in the wall.
  ASSERT_TRUE(std::holds_alternative<Mesh>(part->shape));
  EXPECT_TRUE(std::get<Mesh>(part->shape).watertight);
  EXPECT_LE(std::get<Mesh>(part->shape).mesh->triangles.size(), 1500u);
  const auto signed_m = [&](const Vector3& p_W) {
    return SignedDistance_m(part->shape, X.inverse() * p_W);
  };
  EXPECT_GT(signed_m({0, 0, 0.7 * height_m}), 0.02);
  const double wall_z = 0.5 * (part->vessel->outer.back().y() + part->vessel->outer.front().y());
  EXPECT_LT(SignedDistance_m(*part->vessel, {0, 0, part->vessel->inner.back().y() - 0.001}), 0);
  EXPECT_LT(
      std::abs(SignedDistance_m(*part->vessel, {OuterRadius_m(wall, 0.5 * height_m), 0, wall_z})),
      0.004);
  EXPECT_GT(ExplainedShare(model), 0.95);
  const FitQuality& fit = *part->fit;
  EXPECT_LT(fit.rms_m, 0.0025);
  EXPECT_GT(fit.observed_fraction, 0.35);
  EXPECT_GT(fit.inlier_ratio, 0.9);
  EXPECT_EQ(part->role, PartRole::kFitted);
  EXPECT_GT(*part->vessel->rim_radius_sigma_m, 0.0003);
  EXPECT_LT(*part->vessel->rim_radius_sigma_m, 0.002);
}

TEST(Shell, OfAMug) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) ExpectShell(MugWall(), seed);
}

TEST(Shell, OfAPan) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) ExpectShell(PanWall(), seed);
}

TEST(Shell, OfABowl) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) ExpectShell(BowlWall(), seed);
}

TEST(Shell, HasTheHandleThatBeginsAtIt) {
  SimulatedObject mug = OfOnePart(MakeMesh(MakeVessel(MugWall())), 0);
  std::vector<TubePoint> bow;
  for (int k = 0; k <= 16; ++k) {
    const double turn_rad = std::numbers::pi * (k / 16.0 - 0.5);
    bow.push_back(
        {.place_xz = {0.036 + 0.035 * std::cos(turn_rad), 0.05 - 0.03 * std::sin(turn_rad)},
         .half_thickness_m = 0.005,
         .half_width_m = 0.006});
  }
  mug.parts.push_back({.shape = MakeMesh(MakeTube(bow))});
  mug.X_WO.linear() = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitZ()).matrix();
  const ObjectModel model = Model(mug, 1);
  const ShapePart* part = OnlyVessel(model);
  ASSERT_NE(part, nullptr);
  ASSERT_EQ(model.handles.size(), 1u);
  EXPECT_EQ(model.handles[0].shape_index, part - model.shapes.data());
}

TEST(Shell, LeavesWhatItHoldsToItself) {
  SimulatedObject bowl = OfOnePart(MakeMesh(MakeVessel(BowlWall())), 0);
  bowl.parts.push_back({MakeTranslation(0, 0, 0.041), Sphere{.radius_m = 0.035}});
  const ObjectModel model = Model(bowl, 2);
  const ShapePart* part = OnlyVessel(model);
  ASSERT_NE(part, nullptr);
  EXPECT_NEAR(part->vessel->rim_radius_m(), 0.075, 2 * kRadius_m);
  // The space above the ball is free, although the bowl's content rises above the floor.
  const Pose X_SW = part->X_OS.inverse();
  EXPECT_GT(SignedDistance_m(*part->vessel, X_SW * Vector3(0, 0, 0.07)), 0.01);
}

TEST(Shell, IsNoneOfACan) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ObjectModel model =
        Model(OfOnePart(Cylinder{.radius_m = 0.04, .length_m = 0.1}, 0.05), seed);
    EXPECT_EQ(OnlyVessel(model), nullptr);
    ASSERT_EQ(model.shapes.size(), 1u);
    EXPECT_TRUE(std::holds_alternative<Cylinder>(model.shapes[0].shape));
  }
}

TEST(Shell, IsNoneOfACupUpsideDown) {
  SimulatedObject cup = OfOnePart(MakeMesh(MakeVessel(MugWall())), 0);
  cup.X_WO.linear() = Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()).matrix();
  cup.X_WO.translation().z() = MugWall().outer.back().height_m;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ObjectModel model = Model(cup, seed);
    EXPECT_EQ(OnlyVessel(model), nullptr);
    ASSERT_FALSE(model.shapes.empty());
    const ShapeKind kind = KindOf(model.shapes[0].shape);
    EXPECT_TRUE(kind == ShapeKind::kCylinder || kind == ShapeKind::kCone) << NameOf(kind);
  }
}

TEST(Shell, IsNoneOfABox) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulatedObject box = OfOnePart(Box{.size_m = {0.12, 0.1, 0.08}}, 0.04);
    box.X_WO.linear() =
        Eigen::AngleAxisd(0.3 * static_cast<double>(seed), Vector3::UnitZ()).matrix();
    const ObjectModel model = Model(box, seed);
    ASSERT_EQ(model.shapes.size(), 1u);
    EXPECT_TRUE(std::holds_alternative<Box>(model.shapes[0].shape));
  }
}

TEST(Shell, IsTheSameInEveryRun) {
  const SimulatedObject pan = OfOnePart(MakeMesh(MakeVessel(PanWall())), 0);
  const ObjectModel first = Model(pan, 5), second = Model(pan, 5);
  ASSERT_NE(OnlyVessel(first), nullptr);
  ASSERT_NE(OnlyVessel(second), nullptr);
  EXPECT_EQ(*OnlyVessel(first)->vessel, *OnlyVessel(second)->vessel);
  EXPECT_EQ(OnlyVessel(first)->X_OS.matrix(), OnlyVessel(second)->X_OS.matrix());
  EXPECT_EQ(first.part_of_point, second.part_of_point);
}

}  // namespace
}  // namespace cwm::perception
