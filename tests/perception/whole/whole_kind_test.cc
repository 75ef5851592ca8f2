#include "perception/whole/whole_kind.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "collision/geometry/aabb.h"

namespace cwm::perception {
namespace {

constexpr double kKindExact = 1e-9;

WholeParameters Listed(std::initializer_list<double> values) {
  WholeParameters x(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), x.data());
  return x;
}

Aabb BoundsOfPlaced(WholeKind kind, std::initializer_list<double> values) {
  const WholeSolid solid = Place(kind, Listed(values));
  return TightBounds(solid.shape, solid.X_GS);
}

void ExpectStands(const Aabb& bounds, double height_m, const Vector2& middle) {
  EXPECT_NEAR(bounds.min().z(), 0, kKindExact);
  EXPECT_NEAR(bounds.max().z(), height_m, kKindExact);
  EXPECT_LT((bounds.center().head<2>() - middle).norm(), kKindExact);
}

TEST(Place, PutsWhatStandsAndWhatLiesOnTheGround) {
  const Vector2 middle(0.1, 0.2);
  ExpectStands(BoundsOfPlaced(WholeKind::kUprightCylinder, {0.1, 0.2, 0.3, 0.04}), 0.3, middle);
  ExpectStands(BoundsOfPlaced(WholeKind::kUprightCone, {0.1, 0.2, 0.3, 0.08, 0.1}), 0.3, middle);
  ExpectStands(BoundsOfPlaced(WholeKind::kUprightBox, {0.1, 0.2, 0.4, 0.06, 0.1, 0.05}), 0.05,
               middle);
  ExpectStands(BoundsOfPlaced(WholeKind::kLyingCylinder, {0.1, 0.2, 0.4, 0.03, 0.2}), 0.06, middle);
  const Aabb ball = BoundsOfPlaced(WholeKind::kBall, {0.1, 0.2, 0.3, 0.04});
  EXPECT_NEAR(ball.min().z(), 0.26, kKindExact);
  const WholeSolid cup = Place(WholeKind::kUprightCone, Listed({0, 0, 0.3, 0.08, 0.1}));
  EXPECT_NEAR(std::get<Cone>(cup.shape).radius_top_m, 0.08, kKindExact);
  EXPECT_NEAR(std::get<Cone>(cup.shape).radius_bottom_m, 0.05, kKindExact);
}

TEST(Place, LeansACylinderOnTheLowestPlaceOfItsRim) {
  for (const double elevation_rad : {0.2, 0.8, 1.3}) {
    const WholeParameters x = Listed({0.1, 0.2, 0.7, elevation_rad, 0.03, 0.2});
    const WholeSolid can = Place(WholeKind::kLeaningCylinder, x);
    const Vector3 axis(std::cos(elevation_rad) * std::cos(0.7),
                       std::cos(elevation_rad) * std::sin(0.7), std::sin(elevation_rad));
    EXPECT_LT((can.X_GS.linear().col(2) - axis).norm(), kKindExact);
    EXPECT_NEAR(TightBounds(can.shape, can.X_GS).min().z(), 0, kKindExact) << elevation_rad;
    const auto back = ParametersOf(WholeKind::kLeaningCylinder, can);
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - x).norm(), kKindExact);
  }
}

TEST(SlopeOf, IsTheLastParameterOfConesAlone) {
  for (const WholeKind kind :
       {WholeKind::kBall, WholeKind::kUprightCylinder, WholeKind::kUprightCone,
        WholeKind::kLyingCylinder, WholeKind::kLyingCone, WholeKind::kLeaningCylinder,
        WholeKind::kUprightBox, WholeKind::kTiltedBox}) {
    const bool is_cone = kind == WholeKind::kUprightCone || kind == WholeKind::kLyingCone;
    const bool lies = kind == WholeKind::kLyingCylinder || kind == WholeKind::kLyingCone;
    EXPECT_EQ(IsConical(kind), is_cone);
    EXPECT_EQ(Lies(kind), lies);
    EXPECT_EQ(SlopeOf(kind, Listed({1, 2, 3, 4, 0.25})), is_cone ? 0.25 : 0);
  }
}

TEST(ParametersOf, AreThoseOfSolidsThatAreNearlyOfTheKindAlone) {
  const Pose at = MakeTranslation(0.1, 0.2, 0.05);
  const auto of_cone = ParametersOf(WholeKind::kUprightCylinder, {at, Cone{0.03, 0.05, 0.1}});
  ASSERT_TRUE(of_cone.has_value());
  EXPECT_LT((*of_cone - Listed({0.1, 0.2, 0.1, 0.04})).norm(), kKindExact);
  const auto of_can = ParametersOf(WholeKind::kUprightCone, {at, Cylinder{0.03, 0.1}});
  ASSERT_TRUE(of_can.has_value());
  EXPECT_LT((*of_can - Listed({0.1, 0.2, 0.1, 0.03, 0})).norm(), kKindExact);
  const WholeSolid upright{Pose::Identity(), Cylinder{0.03, 0.1}};
  WholeSolid level = upright, turned_over = upright;
  level.X_GS.linear() = BasisFromZ(Vector3(std::cos(0.3), 0, std::sin(0.3)));
  turned_over.X_GS.linear() = BasisFromZ(-Vector3::UnitZ());
  EXPECT_TRUE(ParametersOf(WholeKind::kLyingCylinder, level).has_value()) << "may be tilted";
  EXPECT_FALSE(ParametersOf(WholeKind::kUprightCylinder, level).has_value());
  EXPECT_FALSE(ParametersOf(WholeKind::kLyingCone, upright).has_value());
  EXPECT_FALSE(ParametersOf(WholeKind::kUprightCone, turned_over).has_value());
  EXPECT_FALSE(ParametersOf(WholeKind::kTiltedBox, upright).has_value());
  const WholeSolid box{Pose::Identity(), Box{{0.1, 0.2, 0.3}}};
  EXPECT_FALSE(ParametersOf(WholeKind::kUprightCylinder, box).has_value());
  EXPECT_FALSE(ParametersOf(WholeKind::kLeaningCylinder, box).has_value());
}

}  // namespace
}  // namespace cwm::perception
