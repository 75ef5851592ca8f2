#include "perception/solids/extended_solid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collision/geometry/aabb.h"
#include "perception/solids/extended_distance.h"

namespace cwm::perception {
namespace {

constexpr double kExact_m = 1e-12;

TEST(Extended, MovesOneEndOfABoxAndNoOtherFace) {
  const Placed<> box{MakeTranslation(1, 2, 3), Box{{0.2, 0.4, 0.6}}};
  const Placed<> longer = Extended(box, {1, -1}, 0.1);
  const Aabb before = TightBounds(box.shape, box.X_FS);
  const Aabb after = TightBounds(longer.shape, longer.X_FS);
  EXPECT_LT((after.min() - before.min() + Vector3(0, 0.1, 0)).norm(), kExact_m);
  EXPECT_LT((after.max() - before.max()).norm(), kExact_m);
}

TEST(Extended, LeavesTheWallOfAConeWhereItIs) {
  const Placed<> cone{MakeTranslation(0, 0, 0.5), Cone{0.05, 0.03, 0.1}};
  for (const double sign : {-1.0, 1.0}) {
    const Placed<> longer = Extended(cone, {2, sign}, 0.04);
    EXPECT_NEAR(*LengthAlong_m(longer.shape, 2), 0.14, kExact_m);
    const Vector3 on_wall(0.04 * std::cos(1.0), 0.04 * std::sin(1.0), 0.5);
    EXPECT_NEAR(ExtendedDistance_m(longer.shape, longer.X_FS.inverse() * on_wall), 0, kExact_m);
    EXPECT_NEAR(TightBounds(longer.shape, longer.X_FS).max().z(), sign > 0 ? 0.59 : 0.55, kExact_m);
  }
}

TEST(Extended, EndsBeforeTheApexOfACone) {
  const Shape cone = Cone{0.05, 0.03, 0.1};
  EXPECT_NEAR(MaxExtension_m(cone, {2, 1}), 0.15, kExact_m);
  EXPECT_TRUE(std::isinf(MaxExtension_m(cone, {2, -1})));
  EXPECT_EQ(MaxExtension_m(Cylinder{0.05, 0.1}, {0, 1}), 0);
  EXPECT_EQ(MaxExtension_m(Sphere{0.05}, {2, 1}), 0);
}

}  // namespace
}  // namespace cwm::perception
