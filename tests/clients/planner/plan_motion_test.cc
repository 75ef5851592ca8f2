#include "clients/planner/plan_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "tests/clients/planner/flat_world.h"

namespace cwm::planner {
namespace {

using ::testing::HasSubstr;

constexpr double kRadius = 0.1;

// A row of discs along x = 0 with a gap of 0.05 at y = 0.5.
std::vector<Disc> WallWithAGap() {
  std::vector<Disc> discs;
  for (double y = 0.5 - 0.125; y > -1.1; y -= kRadius) discs.push_back({0, y, kRadius});
  for (double y = 0.5 + 0.125; y < 1.1; y += kRadius) discs.push_back({0, y, kRadius});
  return discs;
}

PlanProblem Across() { return {.joints = Flat(), .start = {-0.8, -0.5}, .goals = {{0.8, -0.5}}}; }

TEST(PlanMotion, FindsTheGapInAWallWithEverySeed) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    FlatWorld world(WallWithAGap());
    const auto plan = PlanMotion(Across(), world, {.time_limit_s = 60, .seed = seed});
    ASSERT_TRUE(plan.ok()) << plan.status();
    ASSERT_EQ(plan->outcome, Outcome::kSolved) << "seed " << seed;
    EXPECT_EQ(plan->path.front(), Across().start);
    EXPECT_EQ(plan->path.back(), Across().goals.front());
    EXPECT_GE(MinClearance(world, plan->path), -MaxDepthBetween(kFineStep, kRadius) - 1e-9);
    // Through the gap the length is at least 2 * hypot(0.8, 1), apart from the gap's width.
    EXPECT_GT(plan->length, 2.4);
    EXPECT_LE(plan->length, plan->found_length + 1e-9);
    EXPECT_EQ(plan->checks.batches, world.counts().batches);
  }
}

TEST(PlanMotion, GoesStraightWhereNothingIsInTheWay) {
  FlatWorld world({});
  const auto plan = PlanMotion(Across(), world, {});
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->path, (std::vector<Row>{Across().start, Across().goals.front()}));
  EXPECT_LE(plan->checks.batches, 3) << "the ends, and the motion at two steps";
}

TEST(PlanMotion, EndsAtTheNearestGoalOfSeveralInAnOpenWorld) {
  FlatWorld world({});
  PlanProblem problem = Across();
  problem.goals = {{0.8, -0.5}, {-0.8, 0.5}, {0.8, 0.8}};
  const auto plan = PlanMotion(problem, world, {});
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->path, (std::vector<Row>{problem.start, {-0.8, 0.5}}));
  EXPECT_LE(plan->checks.batches, 3);
}

TEST(PlanMotion, LeavesOutGoalsThatAreNotFreeOrCannotBeReached) {
  std::vector<Disc> closed = WallWithAGap();
  closed.push_back({0, 0.5, kRadius});
  closed.push_back({-0.5, 0.5, kRadius});
  closed.push_back({-0.5, 0, kRadius});
  FlatWorld world(closed);
  PlanProblem problem = Across();
  // Out of limits, in collision, behind the wall, and one that can be reached, around a disc.
  problem.goals = {{-1.01, 0}, {-0.5, 0.5}, {0.8, 0}, {-0.25, 0.4}};
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const auto plan = PlanMotion(problem, world, {.time_limit_s = 60, .seed = seed});
    ASSERT_TRUE(plan.ok());
    ASSERT_EQ(plan->outcome, Outcome::kSolved) << seed;
    EXPECT_EQ(plan->path.back(), problem.goals.back());
    EXPECT_GE(MinClearance(world, plan->path), -MaxDepthBetween(kFineStep, kRadius) - 1e-9);
  }
  problem.goals = {{-1.01, 0}, {-0.5, 0.5}};
  EXPECT_EQ(PlanMotion(problem, world, {})->outcome, Outcome::kGoalInCollision);
  problem.goals = {{-1.01, 0}, {-0.5, 2}};
  const auto outside = PlanMotion(problem, world, {});
  EXPECT_EQ(outside->outcome, Outcome::kGoalOutOfLimits);
  EXPECT_EQ(outside->joint, 0u) << "that of the first goal";
}

TEST(PlanMotion, PlansTheSameForTheSameSeed) {
  const auto path = [](std::uint32_t seed) {
    FlatWorld world(WallWithAGap());
    return PlanMotion(Across(), world, {.time_limit_s = 60, .seed = seed})->path;
  };
  EXPECT_EQ(path(3), path(3));
  EXPECT_NE(path(3), path(4));
}

TEST(PlanMotion, SaysWhichEndIsWrong) {
  FlatWorld world({{-0.8, -0.5, 0.1}, {0, 0, 0.1}});
  const auto outcome = [&](Row start, Row goal) {
    return *PlanMotion({.joints = Flat(), .start = std::move(start), .goals = {std::move(goal)}},
                       world, {});
  };
  EXPECT_EQ(outcome({-0.8, -0.5}, {0, 0}).outcome, Outcome::kStartInCollision);
  EXPECT_EQ(outcome({0.8, 0.5}, {0, 0}).outcome, Outcome::kGoalInCollision);
  const PlanResult start = outcome({0, 1.01}, {0, 2});
  EXPECT_EQ(start.outcome, Outcome::kStartOutOfLimits);
  EXPECT_EQ(start.joint, 1u);
  const PlanResult goal = outcome({0, 1}, {-1.01, 0});
  EXPECT_EQ(goal.outcome, Outcome::kGoalOutOfLimits);
  EXPECT_EQ(goal.joint, 0u);
}

TEST(PlanMotion, EndsInTimeWithoutAPath) {
  std::vector<Disc> closed = WallWithAGap();
  closed.push_back({0, 0.5, kRadius});
  FlatWorld world(closed);
  const auto plan = PlanMotion(Across(), world, {.time_limit_s = 0.05});
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->outcome, Outcome::kNoPath);
  EXPECT_TRUE(plan->path.empty());
}

// A wall that the coarse step jumps over: trees grow through it, and the fine check cuts them off.
TEST(PlanMotion, FindsTheGapInAWallThinnerThanTheCoarseStep) {
  std::vector<Disc> thin;
  constexpr double kThin = 0.012;
  for (double y = -1.1; y < 1.1; y += kThin) {
    if (y < 0.45 || y > 0.55) thin.push_back({0, y, kThin});
  }
  FlatWorld world(thin);
  const auto plan = PlanMotion(Across(), world, {.time_limit_s = 60});
  ASSERT_TRUE(plan.ok());
  ASSERT_EQ(plan->outcome, Outcome::kSolved);
  EXPECT_GE(MinClearance(world, plan->path), -MaxDepthBetween(kFineStep, kThin) - 1e-9);
}

TEST(PlanMotion, RefusesWhatIsNoProblem) {
  FlatWorld world({});
  const auto refusal = [&](PlanProblem problem) {
    return std::string(PlanMotion(problem, world, {}).status().message());
  };
  PlanProblem problem = Across();
  problem.start = {0};
  EXPECT_THAT(refusal(problem),
              HasSubstr("start has 1 numbers, must have one for each of 2 joints"));
  problem = Across();
  problem.goals[0][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(problem), HasSubstr("goal: y is nan, must be finite"));
  problem = Across();
  problem.joints[0].lower = 2;
  EXPECT_THAT(refusal(problem), HasSubstr("x: limits are 2 to 1, must not cross"));
  EXPECT_THAT(refusal({}), HasSubstr("joints: there is none"));
  problem = Across();
  problem.goals.clear();
  EXPECT_THAT(refusal(problem), HasSubstr("goals: there is none"));
  EXPECT_EQ(world.counts().batches, 0);
}

// A server that disappears after some answers.
class FailingWorld : public StateChecker {
 public:
  explicit FailingWorld(int answers) : world_(WallWithAGap()), left_(answers) {}

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Evaluate(std::span<const double> rows,
                                                     std::size_t width) override {
    if (left_-- == 0) return absl::UnavailableError("gone");
    return world_.CheckStates(rows, width);
  }

  FlatWorld world_;
  int left_;
};

TEST(PlanMotion, TellsAtWhateverQuestionTheCheckerFails) {
  FlatWorld counted(WallWithAGap());
  ASSERT_TRUE(PlanMotion(Across(), counted, {.time_limit_s = 60}).ok());
  for (int answers = 0; answers < counted.counts().batches; ++answers) {
    FailingWorld world(answers);
    const auto plan = PlanMotion(Across(), world, {.time_limit_s = 60});
    EXPECT_TRUE(absl::IsUnavailable(plan.status())) << answers;
  }
}

}  // namespace
}  // namespace cwm::planner
