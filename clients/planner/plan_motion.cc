#include "clients/planner/plan_motion.h"

#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/geometric/PathGeometric.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::planner {
namespace {

namespace ob = ompl::base;
using Clock = std::chrono::steady_clock;

double ElapsedSince_s(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

absl::Status CheckRow(const PlanProblem& problem, const Row& row, const char* name) {
  if (row.size() != problem.joints.size()) {
    return absl::InvalidArgumentError(absl::StrCat(name, " has ", row.size(),
                                                   " numbers, must have one for each of ",
                                                   problem.joints.size(), " joints"));
  }
  for (std::size_t j = 0; j < row.size(); ++j) {
    if (std::isfinite(row[j])) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": ", problem.joints[j].name, " is ", row[j], ", must be finite"));
  }
  return absl::OkStatus();
}

absl::Status CheckProblem(const PlanProblem& problem) {
  if (problem.joints.empty()) {
    return absl::InvalidArgumentError("joints: there is none, must be at least one");
  }
  for (const Joint& joint : problem.joints) {
    if (joint.kind == Joint::Kind::kLimited && !(joint.lower <= joint.upper)) {
      return absl::InvalidArgumentError(absl::StrCat(joint.name, ": limits are ", joint.lower,
                                                     " to ", joint.upper, ", must not cross"));
    }
  }
  if (problem.goals.empty()) {
    return absl::InvalidArgumentError("goals: there is none, must be at least one");
  }
  if (absl::Status status = CheckRow(problem, problem.start, "start"); !status.ok()) return status;
  for (const Row& goal : problem.goals) {
    if (absl::Status status = CheckRow(problem, goal, "goal"); !status.ok()) return status;
  }
  return absl::OkStatus();
}

// Checks single states, for OMPL's own code; BatchConnect uses batches.
class SingleStateValidity : public ob::StateValidityChecker {
 public:
  SingleStateValidity(ob::SpaceInformation* information, const JointSpace& space,
                      StateChecker& checker)
      : ob::StateValidityChecker(information), space_(space), checker_(checker) {}

  bool isValid(const ob::State* state) const override {
    const auto free = checker_.CheckStates(space_.RowOf(state), space_.width());
    return free.ok() && free->front() == 1;
  }

 private:
  const JointSpace& space_;
  StateChecker& checker_;
};

// The outcome if an end of the path is invalid; empty if the start and a goal are free. Sets the
// goals that are.
absl::StatusOr<std::optional<Outcome>> CheckEnds(const JointSpace& space,
                                                 const PlanProblem& problem, StateChecker& checker,
                                                 PlanResult& result, std::vector<Row>& goals) {
  if ((result.joint = space.OutOfLimits(problem.start))) return Outcome::kStartOutOfLimits;
  std::vector<Row> within;
  for (const Row& goal : problem.goals) {
    if (!space.OutOfLimits(goal)) within.push_back(goal);
  }
  if (within.empty()) {
    result.joint = space.OutOfLimits(problem.goals.front());
    return Outcome::kGoalOutOfLimits;
  }
  EdgeBatch ends(space, checker);
  ends.Add(problem.start);
  for (const Row& goal : within) ends.Add(goal);
  if (absl::Status status = ends.CheckAll(); !status.ok()) return status;
  if (!ends.IsFree(0)) return Outcome::kStartInCollision;
  for (std::size_t k = 0; k < within.size(); ++k) {
    if (ends.IsFree(1 + k)) goals.push_back(std::move(within[k]));
  }
  if (goals.empty()) return Outcome::kGoalInCollision;
  return std::nullopt;
}

// Empty if no path was found in time.
absl::StatusOr<std::vector<Row>> FindPath(const std::shared_ptr<JointSpace>& space,
                                          const Row& start_row, const std::vector<Row>& goals,
                                          StateChecker& checker, const PlanOptions& options,
                                          PlanResult& result) {
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      std::make_shared<SingleStateValidity>(information.get(), *space, checker));
  information->setup();
  const auto definition = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> state(space);
  std::copy(start_row.begin(), start_row.end(), space->RowOf(state.get()).begin());
  definition->addStartState(state);
  const auto any_goal = std::make_shared<ob::GoalStates>(information);
  for (const Row& goal : goals) {
    std::copy(goal.begin(), goal.end(), space->RowOf(state.get()).begin());
    any_goal->addState(state);
  }
  definition->setGoal(any_goal);
  BatchConnect planner(information, checker, options.connect);
  planner.setProblemDefinition(definition);
  planner.setup();
  const Clock::time_point begin = Clock::now();
  const ob::PlannerTerminationCondition out_of_time(
      [&] { return ElapsedSince_s(begin) >= options.time_limit_s; });
  const ob::PlannerStatus solved = planner.solve(out_of_time);
  result.rounds = planner.rounds();
  if (!planner.status().ok()) return planner.status();
  std::vector<Row> path;
  if (!solved) return path;
  auto* found = definition->getSolutionPath()->as<ompl::geometric::PathGeometric>();
  for (const ob::State* node : found->getStates()) {
    const std::span<const double> row = space->RowOf(node);
    path.emplace_back(row.begin(), row.end());
  }
  return path;
}

}  // namespace

absl::StatusOr<PlanResult> PlanMotion(const PlanProblem& problem, StateChecker& checker,
                                      const PlanOptions& options) {
  if (absl::Status status = CheckProblem(problem); !status.ok()) return status;
  const CheckCounts before = checker.counts();
  const auto space = std::make_shared<JointSpace>(problem.joints, options.seed);
  PlanResult result;
  const auto done = [&](Outcome outcome) {
    result.outcome = outcome;
    result.checks = {.batches = checker.counts().batches - before.batches,
                     .states = checker.counts().states - before.states};
    return result;
  };
  const Clock::time_point start = Clock::now();
  std::vector<Row> goals;
  const auto ends = CheckEnds(*space, problem, checker, result, goals);
  if (!ends.ok()) return ends.status();
  if (*ends) return done(**ends);
  auto path = FindPath(space, problem.start, goals, checker, options, result);
  if (!path.ok()) return path.status();
  result.finding_s = ElapsedSince_s(start);
  if (path->empty()) return done(Outcome::kNoPath);
  const Clock::time_point found = Clock::now();
  result.found_length = LengthOf(*space, *path);
  ShorteningOptions shortening = options.shortening;
  shortening.seed = options.seed;
  auto shorter = Shorten(*space, checker, *std::move(path), shortening);
  if (!shorter.ok()) return shorter.status();
  result.path = *std::move(shorter);
  result.length = LengthOf(*space, result.path);
  result.shortening_s = ElapsedSince_s(found);
  return done(Outcome::kSolved);
}

}  // namespace cwm::planner
