#include "perception/primitive_fit/primitive_fit_starts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/geometry/signed_distance.h"

namespace cwm::perception {
namespace {

using ::testing::DoubleNear;
using ::testing::Pointwise;

constexpr double kStartExact = 1e-9;

PointsOnGround OfPoints(const std::vector<Vector3>& places) {
  PointsOnGround points;
  points.viewpoint_G = Vector3(-1, 0, 0.5);
  points.p_G = places;
  points.sigma_m.assign(places.size(), 0.0015);
  return points;
}

// The half of a can of 3 cm radius and 10 cm height that faces -x.
std::vector<Vector3> HalfOfACan() {
  std::vector<Vector3> places;
  for (int row = 1; row <= 10; ++row) {
    for (int k = -15; k <= 15; ++k) {
      const double turn_rad = std::numbers::pi * (1 + k / 30.0);
      places.emplace_back(0.05 + 0.03 * std::cos(turn_rad), 0.02 + 0.03 * std::sin(turn_rad),
                          0.01 * row);
    }
  }
  return places;
}

TEST(StartsOf, PassThroughTheHalfThatIsSeenOfACanAndLeanConesToBothSides) {
  const auto cans = StartsOf(PrimitiveKind::kUprightCylinder, {}, OfPoints(HalfOfACan()));
  ASSERT_EQ(cans.size(), 2u);
  EXPECT_LT(cans[0](3), 0.03) << "within the extent";
  EXPECT_LT((cans[1] - Eigen::Vector4d(0.05, 0.02, 0.1, 0.03)).norm(), kStartExact);
  Solid cup;
  cup.shape = Cone{0.03, 0.05, 0.1};
  cup.X_MS.translation().z() = 0.05;
  const auto cups = StartsOf(PrimitiveKind::kUprightCone, {cup}, OfPoints(HalfOfACan()));
  std::vector<double> slopes;
  for (const PrimitiveParameters& x : cups)
    slopes.push_back(SlopeOf(PrimitiveKind::kUprightCone, x));
  std::ranges::sort(slopes);
  // A circle and an extent, each leaning to either side, and the cup's own slope.
  const double lean = kSlopeSpread * std::sqrt(2 / std::numbers::pi);
  EXPECT_THAT(slopes, Pointwise(DoubleNear(kStartExact), {-lean, -lean, lean, lean, 0.2}));
}

// Only the end of a lying can is visible.
TEST(StartsOf, ReachAwayFromTheSensorBehindTheEndOfWhatLies) {
  std::vector<Vector3> end;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      if (i * i + j * j <= 36) end.emplace_back(0, 0.005 * i, 0.03 + 0.005 * j);
    }
  }
  int behind = 0;
  for (const auto& x : StartsOf(PrimitiveKind::kLyingCylinder, {}, OfPoints(end))) {
    if (std::abs(std::cos(x(2))) < 0.99 || x(4) < x(3)) continue;
    ++behind;
    EXPECT_NEAR(x(4), kHiddenRadii * x(3), kStartExact);
    EXPECT_NEAR(x(0), 0.5 * x(4), kStartExact) << "from the end on";
    EXPECT_NEAR(x(3), 0.03, 0.003);
  }
  EXPECT_EQ(behind, 1);
}

TEST(StartsOf, CoverTheTopOfABoxAndAreNoneOfALineOrOfNothing) {
  EXPECT_TRUE(StartsOf(PrimitiveKind::kBall, {}, PointsOnGround()).empty());
  EXPECT_TRUE(StartsOf(PrimitiveKind::kUprightBox, {}, OfPoints({{0, 0, 0.1}, {1, 0, 0.2}}))
                  .empty());  // points on a line
  const Pose X = MakePose({0.01, 0.02, 0.03}, Quaternion(Eigen::AngleAxisd(0.4, Vector3::UnitZ())));
  std::vector<Vector3> top;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -4; j <= 4; ++j) top.push_back(X * Vector3(0.01 * i, 0.01 * j, 0.03));
  }
  const auto upright = StartsOf(PrimitiveKind::kUprightBox, {}, OfPoints(top));
  ASSERT_EQ(upright.size(), 1u);
  const PlacedPrimitive placed = Place(PrimitiveKind::kUprightBox, upright[0]);
  EXPECT_NEAR(upright[0](3) * upright[0](4), 0.12 * 0.08, kStartExact);
  for (const Vector3& p : top) {
    EXPECT_NEAR(SignedDistance_m(placed.shape, placed.X_GS.inverse() * p), 0, kStartExact);
  }
}

// A square face half-way up that faces +x and up: a leaning solid may begin with it. Known solids
// are given in the frame of the model points.
TEST(StartsOf, ReachFromAKnownFaceToTheGround) {
  PointsOnGround points = OfPoints(HalfOfACan());
  points.X_MG = MakePose({0.1, 0, -0.2}, Quaternion(Eigen::AngleAxisd(0.3, Vector3::UnitX())));
  Pose X_GS = MakeTranslation(0.1, 0.2, 0.15);
  X_GS.linear() = BasisFromZ(Vector3(1, 0, 1).normalized());
  Solid face;
  face.shape = Box{{0.06, 0.06, 0.004}};
  face.X_MS = points.X_MG * X_GS;
  const auto alone = StartsOf(PrimitiveKind::kLeaningCylinder, {}, points);
  const auto starts = StartsOf(PrimitiveKind::kLeaningCylinder, {face}, points);
  ASSERT_EQ(starts.size(), alone.size() + 1);
  EXPECT_NEAR(starts.back()(4), 0.03, kStartExact);
  const PlacedPrimitive can = Place(PrimitiveKind::kLeaningCylinder, starts.back());
  const Vector3 end = can.X_GS * Vector3(0, 0, 0.5 * std::get<Cylinder>(can.shape).length_m);
  EXPECT_LT((end - X_GS * Vector3(0, 0, 0.002)).norm(), kStartExact);
}

}  // namespace
}  // namespace cwm::perception
