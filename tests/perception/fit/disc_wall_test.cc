#include "perception/fit/disc_wall.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/cloud/tolerances.h"
#include "perception/fit/model_selection.h"
#include "tests/perception/fit/exact_fits.h"

namespace cwm::perception {
namespace {

constexpr double kLidHeight_m = 0.1, kLidRadius_m = 0.04;
constexpr double kSeenArc_rad = 140 * kDegree;  // of the wall, around +x, where the sensor is
constexpr int kWallRows = 28;                   // from 9 to 90 mm of height
const Vector3 kFromAside(2, 0, 2.1), kFromAbove(0, 0, 2.1);
// chosen: with 1000 points on 31 sectors, a rim is known to half a millimetre.
constexpr double kRimError_m = 0.0005;
// derived: the distance between two slopes that are tried.
constexpr double kSlopeError = kMinSlope / 2;

// A wall of this slope below the edge of the lid.
ConeModel WallBelow(double slope) {
  const double middle_m = 0.0495;
  return {.point = Vector3(0, 0, middle_m),
          .radius_m = kLidRadius_m + slope * (middle_m - kLidHeight_m),
          .slope = slope};
}

ExactPoints LidAbove(const ConeModel& wall) {
  ExactPoints exact;
  exact.seen.viewpoint = kFromAside;
  exact.AddDisc(Vector3(0, 0, kLidHeight_m), kLidRadius_m, 1000);
  exact.AddWall(wall, kWallRows, kSeenArc_rad);
  return exact;
}

std::size_t CountOnWall(const ConeModel& wall) {
  return static_cast<std::size_t>(kWallRows) *
         static_cast<std::size_t>(ExactPoints::ColumnsOf(wall, kSeenArc_rad));
}

std::optional<ShapeFit> WallOf(const ExactFits& fits) {
  ShapeFit lid;
  lid.model = PlaneModel{.point = fits.Local(Vector3(0, 0, kLidHeight_m))};
  return FindWallBehindDisc(lid, fits.Context(), fits.available);
}

TEST(FindWallBehindDisc, IsACylinderBelowTheEdgeOfALid) {
  const ExactFits fits(LidAbove(WallBelow(0)));
  const auto wall = WallOf(fits);
  ASSERT_TRUE(wall);
  const auto* can = std::get_if<CylinderModel>(&wall->model);
  ASSERT_NE(can, nullptr);
  EXPECT_EQ(wall->axis, AxisFreedom::kHeld);
  EXPECT_EQ(can->axis, Vector3::UnitZ());
  EXPECT_NEAR(can->radius_m, kLidRadius_m, kRimError_m);
  EXPECT_LT(fits.Made(can->point).head<2>().norm(), kRimError_m);
  EXPECT_EQ(wall->inliers.size(), CountOnWall(WallBelow(0)));
  EXPECT_EQ(wall->covariance.rows(), CylinderModel::kParameterCount);
}

TEST(FindWallBehindDisc, HasTheSlopeOfACup) {
  for (const double slope : {0.2, -0.15}) {
    const ExactFits fits(LidAbove(WallBelow(slope)));
    const auto wall = WallOf(fits);
    ASSERT_TRUE(wall) << slope;
    const auto* cup = std::get_if<ConeModel>(&wall->model);
    ASSERT_NE(cup, nullptr) << slope;
    EXPECT_NEAR(cup->slope, slope, kSlopeError);
    EXPECT_NEAR(cup->Distance_m(fits.Local(Vector3(kLidRadius_m, 0, kLidHeight_m))), 0,
                2 * kRimError_m);
    EXPECT_EQ(wall->inliers.size(), CountOnWall(WallBelow(slope)));
    EXPECT_EQ(wall->covariance.rows(), ConeModel::kParameterCount);
  }
}

TEST(FindWallBehindDisc, HoldsMostOfWhatIsAvailableBehind) {
  ExactPoints exact = LidAbove(WallBelow(0));
  exact.AddDisc(Vector3(0, 0, 0.0503), 0.03, 1000);  // a shelf, more than the wall has
  ExactFits fits(exact);
  EXPECT_FALSE(WallOf(fits));
  fits.TakeAway([](const Vector3& p) { return p.z() < 0.095 && p.head<2>().norm() < 0.035; });
  const auto wall = WallOf(fits);
  ASSERT_TRUE(wall);
  EXPECT_EQ(wall->inliers.size(), CountOnWall(WallBelow(0)));
  fits.TakeAway([](const Vector3& p) { return p.z() < 0.095; });
  EXPECT_FALSE(WallOf(fits)) << "of no point";
}

TEST(FindWallBehindDisc, IsRefusedWhereNoRoundWallCanBe) {
  ExactPoints exact;
  exact.seen.viewpoint = kFromAbove;
  exact.AddGrid(Vector3(0, 0, kLidHeight_m), Vector3::UnitZ(), 27, 27);
  exact.AddWall({.point = Vector3(0, 0, 0.0495), .radius_m = 0.045}, kWallRows, 360 * kDegree);
  EXPECT_FALSE(WallOf(ExactFits(exact))) << "the edge of a square is no circle";
  ExactFits fits(LidAbove(WallBelow(0)));
  fits.options.max_radius_m = 0.03;
  EXPECT_FALSE(WallOf(fits)) << "too wide";
  fits.options = ModelerOptions{.search_cylinders = false};
  EXPECT_FALSE(WallOf(fits)) << "no cone is straight";
  ShapeFit ball;
  ball.model = SphereModel{.radius_m = kLidRadius_m};
  EXPECT_FALSE(FindWallBehindDisc(ball, fits.Context(), fits.available)) << "no disc";
}

}  // namespace
}  // namespace cwm::perception
