#include "perception/primitive_fit/primitive_kind.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "collision/geometry/aabb.h"

namespace cwm::perception {
namespace {

constexpr double kKindExact = 1e-9;

PrimitiveParameters Listed(std::initializer_list<double> values) {
  PrimitiveParameters x(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), x.data());
  return x;
}

Aabb BoundsOfPlaced(PrimitiveKind kind, std::initializer_list<double> values) {
  const PlacedPrimitive solid = Place(kind, Listed(values));
  return TightBounds(solid.shape, solid.X_GS);
}

void ExpectStands(const Aabb& bounds, double height_m, const Vector2& middle) {
  EXPECT_NEAR(bounds.min().z(), 0, kKindExact);
  EXPECT_NEAR(bounds.max().z(), height_m, kKindExact);
  EXPECT_LT((bounds.center().head<2>() - middle).norm(), kKindExact);
}

TEST(Place, PutsWhatStandsAndWhatLiesOnTheGround) {
  const Vector2 middle(0.1, 0.2);
  ExpectStands(BoundsOfPlaced(PrimitiveKind::kUprightCylinder, {0.1, 0.2, 0.3, 0.04}), 0.3, middle);
  ExpectStands(BoundsOfPlaced(PrimitiveKind::kUprightCone, {0.1, 0.2, 0.3, 0.08, 0.1}), 0.3,
               middle);
  ExpectStands(BoundsOfPlaced(PrimitiveKind::kUprightBox, {0.1, 0.2, 0.4, 0.06, 0.1, 0.05}), 0.05,
               middle);
  ExpectStands(BoundsOfPlaced(PrimitiveKind::kLyingCylinder, {0.1, 0.2, 0.4, 0.03, 0.2}), 0.06,
               middle);
  const Aabb ball = BoundsOfPlaced(PrimitiveKind::kBall, {0.1, 0.2, 0.3, 0.04});
  EXPECT_NEAR(ball.min().z(), 0.26, kKindExact);
  const PlacedPrimitive cup = Place(PrimitiveKind::kUprightCone, Listed({0, 0, 0.3, 0.08, 0.1}));
  EXPECT_NEAR(std::get<Cone>(cup.shape).radius_top_m, 0.08, kKindExact);
  EXPECT_NEAR(std::get<Cone>(cup.shape).radius_bottom_m, 0.05, kKindExact);
}

TEST(Place, LeansACylinderOnTheLowestPlaceOfItsRim) {
  for (const double elevation_rad : {0.2, 0.8, 1.3}) {
    const PrimitiveParameters x = Listed({0.1, 0.2, 0.7, elevation_rad, 0.03, 0.2});
    const PlacedPrimitive can = Place(PrimitiveKind::kLeaningCylinder, x);
    const Vector3 axis(std::cos(elevation_rad) * std::cos(0.7),
                       std::cos(elevation_rad) * std::sin(0.7), std::sin(elevation_rad));
    EXPECT_LT((can.X_GS.linear().col(2) - axis).norm(), kKindExact);
    EXPECT_NEAR(TightBounds(can.shape, can.X_GS).min().z(), 0, kKindExact) << elevation_rad;
    const auto back = ParametersOf(PrimitiveKind::kLeaningCylinder, can);
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - x).norm(), kKindExact);
  }
}

TEST(SlopeOf, IsTheLastParameterOfConesAlone) {
  for (const PrimitiveKind kind :
       {PrimitiveKind::kBall, PrimitiveKind::kUprightCylinder, PrimitiveKind::kUprightCone,
        PrimitiveKind::kLyingCylinder, PrimitiveKind::kLyingCone, PrimitiveKind::kLeaningCylinder,
        PrimitiveKind::kUprightBox, PrimitiveKind::kTiltedBox}) {
    const bool is_cone = kind == PrimitiveKind::kUprightCone || kind == PrimitiveKind::kLyingCone;
    const bool lies = kind == PrimitiveKind::kLyingCylinder || kind == PrimitiveKind::kLyingCone;
    EXPECT_EQ(IsConical(kind), is_cone);
    EXPECT_EQ(IsLying(kind), lies);
    EXPECT_EQ(SlopeOf(kind, Listed({1, 2, 3, 4, 0.25})), is_cone ? 0.25 : 0);
  }
}

TEST(ParametersOf, AreThoseOfSolidsThatAreNearlyOfTheKindAlone) {
  const Pose at = MakeTranslation(0.1, 0.2, 0.05);
  const auto of_cone = ParametersOf(PrimitiveKind::kUprightCylinder, {at, Cone{0.03, 0.05, 0.1}});
  ASSERT_TRUE(of_cone.has_value());
  EXPECT_LT((*of_cone - Listed({0.1, 0.2, 0.1, 0.04})).norm(), kKindExact);
  const auto of_can = ParametersOf(PrimitiveKind::kUprightCone, {at, Cylinder{0.03, 0.1}});
  ASSERT_TRUE(of_can.has_value());
  EXPECT_LT((*of_can - Listed({0.1, 0.2, 0.1, 0.03, 0})).norm(), kKindExact);
  const PlacedPrimitive upright{Pose::Identity(), Cylinder{0.03, 0.1}};
  PlacedPrimitive level = upright, turned_over = upright;
  level.X_GS.linear() = BasisFromZ(Vector3(std::cos(0.3), 0, std::sin(0.3)));
  turned_over.X_GS.linear() = BasisFromZ(-Vector3::UnitZ());
  EXPECT_TRUE(ParametersOf(PrimitiveKind::kLyingCylinder, level).has_value()) << "may be tilted";
  EXPECT_FALSE(ParametersOf(PrimitiveKind::kUprightCylinder, level).has_value());
  EXPECT_FALSE(ParametersOf(PrimitiveKind::kLyingCone, upright).has_value());
  EXPECT_FALSE(ParametersOf(PrimitiveKind::kUprightCone, turned_over).has_value());
  EXPECT_FALSE(ParametersOf(PrimitiveKind::kTiltedBox, upright).has_value());
  const PlacedPrimitive box{Pose::Identity(), Box{{0.1, 0.2, 0.3}}};
  EXPECT_FALSE(ParametersOf(PrimitiveKind::kUprightCylinder, box).has_value());
  EXPECT_FALSE(ParametersOf(PrimitiveKind::kLeaningCylinder, box).has_value());
}

}  // namespace
}  // namespace cwm::perception
