#include "clients/planner/joint_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "tests/clients/planner/flat_world.h"

namespace cwm::planner {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-12;

std::vector<Joint> TurnAndSlide() {
  return {{.name = "turn", .kind = Joint::Kind::kContinuous},
          {.name = "slide", .kind = Joint::Kind::kLimited, .lower = 0, .upper = 0.5}};
}

TEST(JointSpace, MovesAContinuousJointTheShortWayAndALimitedOneStraight) {
  const JointSpace space(TurnAndSlide(), 1);
  const Row a = {3, 0.1}, b = {-3, 0.4};
  EXPECT_NEAR(space.Distance(a, b), std::hypot(2 * kPi - 6, 0.3), kRounding);
  Row middle(2);
  space.Interpolate(a, b, 0.5, middle);
  EXPECT_NEAR(std::abs(middle[0]), kPi, kRounding);
  EXPECT_NEAR(middle[1], 0.25, kRounding);
  // Full turns do not change the distance.
  EXPECT_NEAR(space.Distance({{3 + 4 * kPi, 0.1}}, b), space.Distance(a, b), kRounding);
}

TEST(JointSpace, EndsAMotionAtItsVeryEnd) {
  const JointSpace space(Flat(), 1);
  for (double x = -1; x < 1; x += 0.0137) {
    Row end(2);
    space.Interpolate({{x, 0.3}}, {{1, -1}}, 1, end);
    EXPECT_EQ(end, (Row{1, -1})) << "a limit is within limits";
  }
}

TEST(JointSpace, NamesTheJointThatIsOutOfLimits) {
  const JointSpace space(TurnAndSlide(), 1);
  EXPECT_FALSE(space.OutOfLimits({{100, 0.5}}).has_value());
  EXPECT_EQ(space.OutOfLimits({{0, 0.5 + 1e-9}}), 1u);
  EXPECT_EQ(space.OutOfLimits({{0, -1e-9}}), 1u);
}

TEST(JointSpace, SamplesTheSameRowsForTheSameSeedWithinLimits) {
  const auto samples = [](std::uint32_t seed) {
    const auto space = std::make_shared<JointSpace>(TurnAndSlide(), seed);
    const auto sampler = space->allocStateSampler();
    ompl::base::State* state = space->allocState();
    std::vector<double> rows;
    for (int k = 0; k < 100; ++k) {
      sampler->sampleUniform(state);
      EXPECT_TRUE(space->satisfiesBounds(state));
      rows.insert(rows.end(), space->RowOf(state).begin(), space->RowOf(state).end());
    }
    space->freeState(state);
    return rows;
  };
  EXPECT_EQ(samples(5), samples(5));
  EXPECT_NE(samples(5), samples(6));
}

}  // namespace
}  // namespace cwm::planner
