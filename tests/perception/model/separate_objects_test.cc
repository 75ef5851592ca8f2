// Bumps that are no handles and surfaces that are not two solids: whole objects as a Kinect sees
// them, and solids alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "perception/handles/handles.h"
#include "perception/handles/vessel_handles.h"
#include "perception/modeler/object_modeler.h"
#include "perception/primitive_fit/single_primitive.h"
#include "perception/solids/explain.h"
#include "perception/solids/extended_distance.h"
#include "tests/perception/model/surfaces.h"

namespace cwm::perception {
namespace {

constexpr double kDistance_m = 0.7;
constexpr double kElevation_rad = 25 * std::numbers::pi / 180;

ObjectModel Model(const SimulatedObject& object, std::uint64_t seed) {
  const ScannedObject scan = ScanOnTable(object, kDistance_m, kElevation_rad, seed);
  return ModelObject(scan.points, scan.X_WSupport, SensorNoise{}, ModelerOptions{});
}

// A cup that lies on its side, turned by `yaw_rad`.
SimulatedObject LyingCup(double yaw_rad) {
  constexpr double kBottom_m = 0.031, kTop_m = 0.047, kLength_m = 0.078;
  const double slope = (kTop_m - kBottom_m) / kLength_m, lean_rad = std::atan(slope);
  SimulatedObject cup{.name = "cup"};
  Pose X = Pose::Identity();
  X.linear() = BasisFromZ(Vector3(std::cos(yaw_rad) * std::cos(lean_rad),
                                  std::sin(yaw_rad) * std::cos(lean_rad), std::sin(lean_rad)));
  X.translation().z() = 0.5 * (kBottom_m + kTop_m) * std::cos(lean_rad);
  cup.parts.push_back({X, Cone{kBottom_m, kTop_m, kLength_m}});
  return cup;
}

TEST(ModelObject, ALyingCupHasNoHandleHoweverItIsTurned) {
  for (int k = 0; k < 24; ++k) {
    const ObjectModel model = Model(LyingCup(k * std::numbers::pi / 12), 40 + k);
    EXPECT_TRUE(model.handles.empty()) << "yaw " << 15 * k;
    EXPECT_EQ(model.shapes.size(), 1u) << "yaw " << 15 * k;
  }
}

// Two balls on a table that just do not touch; the small one lies in the direction `azimuth_rad`.
SimulatedObject TwoBalls(double azimuth_rad) {
  constexpr double kLarge_m = 0.05, kSmall_m = 0.021, kApart_m = kLarge_m + kSmall_m + 0.002;
  const double level_m = std::sqrt(kApart_m * kApart_m - std::pow(kLarge_m - kSmall_m, 2));
  SimulatedObject balls = OfOnePart(Sphere{kLarge_m}, kLarge_m);
  balls.parts.push_back(
      {MakeTranslation(level_m * std::cos(azimuth_rad), level_m * std::sin(azimuth_rad), kSmall_m),
       Sphere{kSmall_m}});
  return balls;
}

TEST(HandlesOfVessel, AreNoBalls) {
  int looks_like_one = 0;
  for (int k = 0; k < 12; ++k) {
    const SimulatedObject balls = TwoBalls(k * std::numbers::pi / 6);
    const ScannedObject scan = ScanOnTable(balls, kDistance_m, kElevation_rad, 40 + k);
    std::vector<ShapePart> shapes;
    for (const Placed<>& part : balls.parts) {
      shapes.push_back({.X_OS = balls.X_WO * part.X_FS, .shape = part.shape});
    }
    const std::vector<std::int32_t> part_of_point = ExplainPoints(scan.points, shapes, kSerialWork);
    const std::optional<Vessel> vessel = Vessel::Find(scan.points, kSerialWork);
    if (!vessel) continue;
    EXPECT_TRUE(HandlesOfVessel(*vessel, scan.points, Ground(), shapes, part_of_point, kSerialWork)
                    .empty());
    shapes.pop_back();
    const std::vector<std::int32_t> unknown = ExplainPoints(scan.points, shapes, kSerialWork);
    looks_like_one +=
        !HandlesOfVessel(*vessel, scan.points, Ground(), shapes, unknown, kSerialWork).empty();
  }
  EXPECT_GT(looks_like_one, 0);  // if it is not recognised as a ball
}

Solid At(double x_m, const Shape& shape) {
  Solid solid;
  solid.X_MS = MakeTranslation(x_m, 0, 0);
  solid.shape = shape;
  return solid;
}

TEST(AnyOverlap, OfTwoBallsWhereOneIsAndNotOfNeighbours) {
  const Sphere ball{0.045};
  EXPECT_TRUE(AnyOverlap({At(0, ball), At(0.004, Sphere{0.042})}));
  EXPECT_FALSE(AnyOverlap({At(0, ball), At(0.09, ball)}));
  EXPECT_FALSE(AnyOverlap({At(0, ball), At(0.08, ball)}));  // 10 mm deep, which noise can cause
}

TEST(AnyOverlap, OfASmallSolidWithinALargeOne) {
  const Box large{{0.2, 0.2, 0.2}};
  EXPECT_TRUE(AnyOverlap({At(0, large), At(0.05, Cylinder{0.02, 0.05})}));
  EXPECT_TRUE(AnyOverlap({At(0.05, Cylinder{0.02, 0.05}), At(0, large)}));
  EXPECT_FALSE(AnyOverlap({At(0, large), At(0.12, Cylinder{0.02, 0.05})}));
}

// Two touching boxes of one height: their tops are one surface without a crease or a jump.
TEST(ModelObject, FindsBothOfTwoBoxesWhoseTopsRunIntoEachOther) {
  const Vector3 first_m(0.12, 0.07, 0.06), second_m(0.05, 0.14, 0.06);
  SimulatedObject boxes = OfOnePart(Box{first_m}, 0.5 * first_m.z());
  boxes.parts.push_back(
      {MakeTranslation(0.5 * (first_m.x() + second_m.x()) + 0.001, 0.02, 0.5 * second_m.z()),
       Box{second_m}});
  constexpr double kSteep_rad = 55 * std::numbers::pi / 180;
  for (std::uint64_t seed = 40; seed < 46; ++seed) {
    const ScannedObject scan = ScanOnTable(boxes, kDistance_m, kSteep_rad, seed);
    const ObjectModel model = ModelObject(scan.points, scan.X_WSupport, SensorNoise{},
                                          ModelerOptions{}, {}, scan.passing);
    ASSERT_EQ(model.shapes.size(), 2u) << seed;
    for (const ShapePart& part : model.shapes) {
      ASSERT_TRUE(std::holds_alternative<Box>(part.shape)) << seed;
      // As high as the true boxes, and no larger than one of them.
      EXPECT_NEAR(std::get<Box>(part.shape).size_m.z(), 0.06, 0.006) << seed;
      EXPECT_LT(std::get<Box>(part.shape).size_m.maxCoeff(), 0.15) << seed;
    }
  }
}

TEST(ModelObject, CutsNoBoxInTwo) {
  for (std::uint64_t seed = 40; seed < 46; ++seed) {
    const ObjectModel model = Model(OfOnePart(Box{{0.21, 0.06, 0.08}}, 0.04), seed);
    EXPECT_EQ(model.shapes.size(), 1u) << seed;
  }
}

TEST(ModelObject, ACylinderThatLeansIsOne) {
  constexpr double kRadius_m = 0.025, kLength_m = 0.14, kLean_rad = 0.6;
  for (int k = 0; k < 8; ++k) {
    const double yaw_rad = k * std::numbers::pi / 4;
    SimulatedObject can{.name = "can"};
    Pose X = Pose::Identity();
    X.linear() = BasisFromZ(Vector3(std::sin(kLean_rad) * std::cos(yaw_rad),
                                    std::sin(kLean_rad) * std::sin(yaw_rad), std::cos(kLean_rad)));
    X.translation().z() = 0.5 * kLength_m * std::cos(kLean_rad) + kRadius_m * std::sin(kLean_rad);
    can.parts.push_back({X, Cylinder{kRadius_m, kLength_m}});
    const ObjectModel model = Model(can, 60 + static_cast<std::uint64_t>(k));
    ASSERT_EQ(model.shapes.size(), 1u) << "yaw " << 45 * k;
    ASSERT_TRUE(std::holds_alternative<Cylinder>(model.shapes[0].shape)) << "yaw " << 45 * k;
    EXPECT_NEAR(std::get<Cylinder>(model.shapes[0].shape).radius_m, kRadius_m, 0.002);
    // Few points show the rims, at grazing angles, so the length is known to 5 sigma.
    EXPECT_NEAR(std::get<Cylinder>(model.shapes[0].shape).length_m, kLength_m,
                0.0075 / std::cos(kLean_rad));
  }
}

TEST(ExtendedDistance, RunsOnBeyondTheEnds) {
  EXPECT_NEAR(ExtendedDistance_m(Cylinder{0.03, 0.1}, Vector3(0, 0.032, 5)), 0.002, 1e-12);
  EXPECT_NEAR(ExtendedDistance_m(Box{{0.2, 0.3, 0.4}}, Vector3(3, 0.149, -7)), 0.001, 1e-12);
  // At 45 degrees, a point a millimetre farther out is 1 / sqrt 2 mm away.
  EXPECT_NEAR(ExtendedDistance_m(Cone{0.1, 0.3, 0.2}, Vector3(1.201, 0, 1)), 0.001 / std::sqrt(2),
              1e-9);
}

}  // namespace
}  // namespace cwm::perception
