// Motions in contact with surfaces. All numbers are binary fractions, so that a gap of 0 is exact.
#include <gtest/gtest.h>

#include <numbers>

#include "collision/motion/check_motions.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

constexpr double kLengths_m[] = {0.001, 0.005, 0.01, 0.05, 0.06, 0.1, 0.2, 0.5, 0.6, 1, 2, 3};

MotionResult Along(const WorldSnapshot& world, const Shape& body_shape, const Pose& from,
                   const Pose& to, const QueryOptions& options = {}) {
  const QueryBody body = BodyFromShapes({{.shape = body_shape}});
  EdgeChecker checker(world, body, options, {});
  return checker.Check(RigidMotion(body, from, to));
}

std::shared_ptr<const WorldSnapshot> Floor(Shape shape, const Pose& X_WO = Pose::Identity()) {
  return WorldOf({PutOf("floor", {{.shape = std::move(shape)}}, X_WO)});
}

TEST(TouchingMotions, GrazeWhateverTheLength) {
  const Pose floor = MakeTranslation(0, 0, -0.5);
  const Shape body = Box{{0.125, 0.125, 0.125}};
  const Plate plate{
      .outline = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}}, .holes = {}, .thickness_m = 0.25};
  for (const auto& world : {Floor(Box{{8, 8, 1}}, floor), Floor(plate), Floor(HalfSpace{})}) {
    for (const double length_m : kLengths_m) {
      const Pose from = MakeTranslation(0, 0.0625, 0.0625);
      EXPECT_EQ(Along(*world, body, from, MakeTranslation(length_m, 0.0625, 0.0625)).verdict,
                MotionVerdict::kGrazing)
          << length_m;
    }
  }
}

TEST(TouchingMotions, GrazeWhereTheyTurnOnTheSpot) {
  const auto world = Floor(Box{{8, 8, 1}}, MakeTranslation(0, 0, -0.5));
  const Pose from = MakeTranslation(0, 0, 0.0625);
  Pose to = MakeTranslation(1, 0, 0.0625);
  to.linear() = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitZ()).toRotationMatrix();
  EXPECT_EQ(Along(*world, Box{{0.5, 0.125, 0.125}}, from, to).verdict, MotionVerdict::kGrazing);
}

TEST(TouchingMotions, AreFreeJustAboveWhateverTheLength) {
  const auto world = Floor(Box{{8, 8, 1}}, MakeTranslation(0, 0, -0.5));
  const double gap_m = 1e-5;
  for (const double length_m : kLengths_m) {
    const MotionResult result =
        Along(*world, Box{{0.125, 0.125, 0.125}}, MakeTranslation(0, 0, 0.0625 + gap_m),
              MakeTranslation(length_m, 0, 0.0625 + gap_m));
    EXPECT_EQ(result.verdict, MotionVerdict::kFree) << length_m;
    EXPECT_NEAR(result.clearance_m, gap_m, 1e-12) << length_m;
  }
}

TEST(TouchingMotions, MeetTheFloorThatTheySinkInto) {
  const auto world = Floor(Box{{8, 8, 1}}, MakeTranslation(0, 0, -0.5));
  for (const double length_m : kLengths_m) {
    const MotionResult result =
        Along(*world, Box{{0.125, 0.125, 0.125}}, MakeTranslation(0, 0, 0.0625 + 0x1p-14),
              MakeTranslation(length_m, 0, 0.0625 - 0x1p-14));
    ASSERT_EQ(result.verdict, MotionVerdict::kContact) << length_m;
    EXPECT_LE(result.lo, 0.5) << length_m;
    EXPECT_GE(result.hi, 0.5) << length_m;
    EXPECT_LE(result.hi - result.lo, kMaxBracketWidth + 0.02)
        << length_m;  // the last micrometre is not proven
  }
}

// A half-space as the moving body, which reaches to infinity.
TEST(TouchingMotions, OfAHalfSpaceAreThoseOfItsPlane) {
  const auto world = WorldOf({PutOf("ball", {{.shape = Sphere{0.25}}}, MakeTranslation(0, 0, 1))});
  for (const double turn_rad : {0.0, 1.0}) {
    const auto at = [&](double z_m, double angle_rad) {
      Pose X_WB = MakeTranslation(0, 0, z_m);
      X_WB.linear() = Eigen::AngleAxisd(angle_rad, Vector3::UnitZ()).toRotationMatrix();
      return X_WB;
    };
    EXPECT_EQ(Along(*world, HalfSpace{}, at(0, 0), at(0.5, turn_rad)).verdict,
              MotionVerdict::kFree);
    const MotionResult met = Along(*world, HalfSpace{}, at(0, 0), at(1, turn_rad));
    EXPECT_NE(met.verdict, MotionVerdict::kFree) << turn_rad;
    if (turn_rad == 0) {
      ASSERT_EQ(met.verdict, MotionVerdict::kContact);
      EXPECT_LE(met.lo, 0.75);
      EXPECT_GE(met.hi, 0.75);
    }
  }
}

// An L with inner edges at x = 0.25 and y = 0.25.
Plate Angle() {
  return {.outline = {{0, 0}, {8, 0}, {8, 0.25}, {0.25, 0.25}, {0.25, 1}, {0, 1}},
          .holes = {},
          .thickness_m = 0.25};
}

// A box that slides along one inner edge reaches the other at x = 0.3125.
constexpr double kMeets_m = 0.3125;

MotionResult InAngle(double from_m, double to_m) {
  const double y_m = 0.25 + 0.0625;
  return Along(*Floor(Angle()), Box{{0.125, 0.125, 0.125}}, MakeTranslation(from_m, y_m, -0.125),
               MakeTranslation(to_m, y_m, -0.125));
}

TEST(TouchingMotions, MeetTheWallThatTheySlideTo) {
  for (const double length_m : kLengths_m) {
    const double from_m = kMeets_m + 0.9 * length_m;
    const MotionResult result = InAngle(from_m, from_m - length_m);
    ASSERT_EQ(result.verdict, MotionVerdict::kContact) << length_m;
    EXPECT_LE(result.lo, 0.9) << length_m;
    EXPECT_NEAR(result.hi, 0.9, 2 * kMaxBracketWidth) << length_m;
    EXPECT_GE(result.hi, 0.9) << length_m;
  }
}

// No plane separates a body from a shape that reaches around it, so the motion is proven only as
// far as the work allows.
TEST(TouchingMotions, AreUndecidedInACornerWhateverTheLength) {
  for (const double length_m : kLengths_m) {
    const MotionVerdict result = InAngle(0.5, 0.5 + length_m).verdict;
    EXPECT_EQ(result, length_m <= 0.001 ? MotionVerdict::kGrazing : MotionVerdict::kUndecided)
        << length_m;
  }
}

}  // namespace
}  // namespace cwm::collision
