#include "perception/primitive_fit/single_primitive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/perception/primitive_fit/seen_on_ground.h"

namespace cwm::perception {
namespace {

const Vector3 kCornerEye(-0.6, -0.3, 0.7);
constexpr std::size_t kSeenPoints = 900;
constexpr double kExactFit_m = 0.001;   // of exact points: the descent ends well within their sigma
constexpr double kHiddenEnd_m = 0.005;  // of an end that only the top shows
const Placed<> kCan{MakeTranslation(0, 0, 0.05), Cylinder{0.04, 0.1}};
const Placed<> kBrick{MakeTranslation(0, 0, 0.025), Box{{0.06, 0.1, 0.05}}};
const Placed<> kBallOnGround{MakeTranslation(0.01, 0.02, 0.03), Sphere{0.03}};

TEST(FitScoreOf, CountsPointsOfNoSolidAsFarAwayAndEachParameter) {
  const SeenOnGround seen(kCornerEye, {kBrick}, kSeenPoints);
  const FitContext context = seen.Context();
  const double samples = context.IndependentSamples(seen.points().size());
  EXPECT_NEAR(FitScoreOf({}, context).value, 9 * samples, 1e-6);  // three sigma, squared
  const Solid brick = seen.Assembled(kBrick);
  const double alone = FitScoreOf({brick}, context).value;
  EXPECT_NEAR(alone, 6 * std::log(samples), 0.1) << "of exact points: its parameters";
  const auto beside = [&](const Shape& shape) {
    return FitScoreOf({brick, seen.Assembled({MakeTranslation(3, 0, 0), shape})}, context).value;
  };
  EXPECT_NEAR(beside(Sphere{0.1}) - alone, 4 * std::log(samples), 1e-6);
  EXPECT_NEAR(beside(Cylinder{0.1, 0.1}) - alone, 5 * std::log(samples), 1e-6);
  const Plate triangle{.outline = {{0, 0}, {1, 0}, {0, 1}}, .holes = {}, .thickness_m = 0.01};
  EXPECT_NEAR(beside(triangle) - alone, 7 * std::log(samples), 1e-6);
}

// A wall and a top that were fitted as two boards.
TEST(ReplaceBySinglePrimitive, PutsACanInThePlaceOfBoardsOnAKnownGroundAlone) {
  const SeenOnGround seen(kCornerEye, {kCan}, kSeenPoints);
  const Assembly boards{
      {seen.Assembled({MakeTranslation(0, 0, 0.0975), Box{{0.08, 0.08, 0.005}}}),
       seen.Assembled({MakeTranslation(-0.04, 0, 0.045), Box{{0.005, 0.06, 0.09}}})},
      {}};
  Assembly nowhere = boards, assembly = boards;
  FitContext context = seen.Context();
  context.ground.known = false;
  ReplaceBySinglePrimitive(context, nowhere);
  ASSERT_EQ(nowhere.solids.size(), 2u);
  EXPECT_EQ(nowhere.solids[0].shape, boards.solids[0].shape);
  ReplaceBySinglePrimitive(seen.Context(), assembly);
  ASSERT_EQ(assembly.solids.size(), 1u);
  const Solid& can = assembly.solids.front();
  ASSERT_TRUE(std::holds_alternative<Cylinder>(can.shape));
  EXPECT_NEAR(std::get<Cylinder>(can.shape).radius_m, 0.04, kExactFit_m);
  EXPECT_NEAR(std::get<Cylinder>(can.shape).length_m, 0.1, kExactFit_m);
  EXPECT_LT((seen.MiddleOf(can) - kCan.X_FS.translation()).norm(), kExactFit_m);
  ASSERT_EQ(can.parameter_sigma.size(), 7u);
  EXPECT_GT(can.parameter_sigma.back(), 0);
}

TEST(ReplaceBySinglePrimitive, KeepsABoxThatIsRightAndCorrectsOneThatIsTooLong) {
  const SeenOnGround seen(kCornerEye, {kBrick}, kSeenPoints);
  Assembly right{{seen.Assembled(kBrick)}, {}};
  ReplaceBySinglePrimitive(seen.Context(), right);
  ASSERT_EQ(right.solids.size(), 1u);
  EXPECT_EQ(right.solids.front().shape, kBrick.shape);
  Assembly longer{{seen.Assembled({kBrick.X_FS, Box{{0.06, 0.14, 0.05}}})}, {}};
  ReplaceBySinglePrimitive(seen.Context(), longer);
  ASSERT_EQ(longer.solids.size(), 1u);
  ASSERT_TRUE(std::holds_alternative<Box>(longer.solids.front().shape));
  Vector3 size_m = std::get<Box>(longer.solids.front().shape).size_m;
  std::sort(size_m.begin(), size_m.end());
  EXPECT_LT((size_m - Vector3(0.05, 0.06, 0.1)).cwiseAbs().maxCoeff(), kHiddenEnd_m);
}

TEST(Refit, IsTheSameKindForOtherPointsThatAreOfItAndNothingForOthers) {
  const SeenOnGround seen(kCornerEye, {kBallOnGround}, kSeenPoints);
  constexpr FitScore kAnything{.value = 1e6, .loss = 1e3};
  const auto ball = FitPrimitive(PrimitiveKind::kBall, {}, kAnything, seen.Context());
  ASSERT_TRUE(ball.has_value());
  std::vector<std::uint32_t> every_other;
  for (std::uint32_t i = 0; i < seen.points().size(); i += 2) every_other.push_back(i);
  const ModelPoints half = Subset(seen.points(), every_other);
  const auto anew = Refit(*ball, seen.ContextOf(half));
  ASSERT_TRUE(anew.has_value());
  EXPECT_EQ(anew->kind, PrimitiveKind::kBall);
  EXPECT_EQ(anew->solid.inliers.size(), half.size());
  EXPECT_LT((seen.MiddleOf(anew->solid) - kBallOnGround.X_FS.translation()).norm(), kExactFit_m);
  const SeenOnGround brick(kCornerEye, {kBrick}, kSeenPoints);
  EXPECT_FALSE(Refit(*ball, brick.Context()).has_value());
}

}  // namespace
}  // namespace cwm::perception
