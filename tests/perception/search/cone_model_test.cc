#include "perception/search/cone_model.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

constexpr double kExact = 1e-12;

// With a slope of 3 to 4, the wall's length is to its height as 5 to 4. The apex is at z = -0.04.
const ConeModel kThreeToFour{.radius_m = 0.03, .slope = 0.75};

Vector3 PlaceAtTurn(double turn_rad, double radius_m, double z_m) {
  return {radius_m * std::cos(turn_rad), radius_m * std::sin(turn_rad), z_m};
}

// Points of the wall 120 degrees apart from each other, each 2 cm above the one before.
std::array<SamplePoint, 3> ConeSampleOf(const ConeModel& cone) {
  std::array<SamplePoint, 3> sample;
  for (int k = 0; k < 3; ++k) {
    const double height_m = 0.02 * (k - 1);
    const Vector3 p =
        cone.point + PlaceAtTurn(k * 120 * kDegree, cone.RadiusAt_m(height_m), height_m);
    sample[static_cast<std::size_t>(k)] = {p, cone.FacingSign() * cone.Normal(p)};
  }
  return sample;
}

// Samples around an axis through (0.1, 0.2), 5 cm from it; `facing` is 1 if the normal points away
// from it.
std::vector<SamplePoint> AroundUpright(const std::vector<double>& facing) {
  std::vector<SamplePoint> sample;
  for (std::size_t k = 0; k < facing.size(); ++k) {
    const Vector3 away = PlaceAtTurn(static_cast<double>(k) * 40 * kDegree, 1, 0);
    sample.push_back(
        {Vector3(0.1, 0.2, 0.01 * static_cast<double>(k)) + 0.05 * away, facing[k] * away});
  }
  return sample;
}

TEST(ConeModel, MeasuresAcrossItsWallAndHasOneNappe) {
  EXPECT_NEAR(kThreeToFour.RadiusAt_m(0.04), 0.06, kExact);
  EXPECT_NEAR(kThreeToFour.Distance_m(Vector3(0, 0.06, 0.04)), 0, kExact);
  const Vector3 beside(0.03 + 0.0125, 0, 0);  // 12.5 mm horizontally, 10 mm to the wall
  EXPECT_NEAR(kThreeToFour.Distance_m(beside), 0.01, kExact);
  EXPECT_NEAR((kThreeToFour.Normal(beside) - Vector3(0.8, 0, -0.6)).norm(), 0, kExact);
  EXPECT_NEAR(kThreeToFour.Distance_m(Vector3(0, 0, 0)), -0.024, kExact);
  EXPECT_NEAR(kThreeToFour.Normal(Vector3(0, 0, 0)).norm(), 1, kExact);
  EXPECT_NEAR(kThreeToFour.Distance_m(Vector3(0, 0, -0.04)), 0, kExact);
  // A point where the other nappe would be, 4 cm below the apex.
  EXPECT_GT(kThreeToFour.Distance_m(Vector3(0.03, 0, -0.08)), 0.03);
  // The same surface, with another point of its axis as the reference.
  const ConeModel centred = kThreeToFour.Centred(Vector3(0.5, 0.1, 0.04));
  EXPECT_NEAR((centred.point - Vector3(0, 0, 0.04)).norm(), 0, kExact);
  EXPECT_NEAR(centred.radius_m, 0.06, kExact);
  EXPECT_NEAR(centred.Distance_m(beside), 0.01, kExact);
}

TEST(ConeModel, ComesBackFromItsSampleWhicheverSideWasSeen) {
  for (const SeenFrom side : {SeenFrom::kOutside, SeenFrom::kInside}) {
    const ConeModel truth{
        .point = Vector3(0.1, -0.2, 0.3), .radius_m = 0.04, .slope = 0.5, .side = side};
    const auto cone = ConeModel::FromSample(ConeSampleOf(truth));
    ASSERT_TRUE(cone);
    EXPECT_EQ(cone->side, side);
    EXPECT_NEAR(std::abs(cone->axis.z()), 1, kExact);
    EXPECT_NEAR(cone->slope * cone->axis.z(), 0.5, 1e-9);
    EXPECT_NEAR(cone->radius_m, 0.04, 1e-9);  // at the mean height of the sample
    EXPECT_NEAR((cone->point - truth.point).norm(), 0, 1e-9);
  }
}

TEST(ConeModel, OfNormalsThatAreAlikeIsNone) {
  std::array<SamplePoint, 3> flat;
  for (std::size_t k = 0; k < flat.size(); ++k) {
    flat[k] = {Vector3(0.01 * static_cast<double>(k), k == 1 ? 0.01 : 0, 0), Vector3::UnitZ()};
  }
  EXPECT_FALSE(ConeModel::FromSample(flat));
  EXPECT_FALSE(ConeModel::AroundAxis(flat, Vector3::UnitZ()));  // normals along the axis
}

TEST(FindAxisFoot, FindsWhereTheNormalsMeetAndTheSideTheyAgreeOn) {
  const auto outside = FindAxisFoot(AroundUpright({1, 1, 1, 1}), Vector3::UnitZ());
  ASSERT_TRUE(outside);
  EXPECT_NEAR((outside->point - Vector3(0.1, 0.2, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(outside->radius_m, 0.05, 1e-9);
  EXPECT_EQ(outside->side, SeenFrom::kOutside);
  const auto inside = FindAxisFoot(AroundUpright({-1, -1, -1, -1}), Vector3::UnitZ());
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->side, SeenFrom::kInside);
  EXPECT_NEAR(inside->radius_m, 0.05, 1e-9);
  EXPECT_FALSE(FindAxisFoot(AroundUpright({1, -1, 1, 1}), Vector3::UnitZ()));  // all must agree
  const std::vector<SamplePoint> parallel = {{Vector3(0, 0, 0), Vector3::UnitX()},
                                             {Vector3(0, 0.05, 0), Vector3::UnitX()}};
  EXPECT_FALSE(FindAxisFoot(parallel, Vector3::UnitZ()));
}

}  // namespace
}  // namespace cwm::perception
