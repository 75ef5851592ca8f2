// The motion planner on the 700 problems of MotionBenchMaker: its states asked of a running server,
// and of FCL in process.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/planner/plan_motion.h"
#include "clients/planner/server_checker.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/fcl_robot.h"
#include "tests/benchmarks/panda_problems.h"
#include "tests/benchmarks/panda_server.h"
#include "tests/benchmarks/planner_benchmarks.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

using planner::PlanResult;

// FCL on the meshes in the process of the planner, one thread, with its tree of boxes.
class FclChecker : public planner::StateChecker {
 public:
  FclChecker(const PandaProblems& all, const PandaProblem& problem)
      : all_(all),
        body_(BodyFromRobot(*all.robot, collision::RobotScope::kBoth)),
        fcl_(body_, *problem.world),
        X_WL_(all.robot->model->links.size()) {}

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Answer(std::span<const double> rows,
                                                   std::size_t) override {
    const collision::JointRows states(*all_.robot->model, *all_.arm,
                                      {.base = DefaultVariables(*all_.robot->model), .rows = rows});
    std::vector<std::uint8_t> free(states.size());
    for (std::size_t k = 0; k < states.size(); ++k) {
      states.Place(k, X_WL_);
      free[k] = states.IsWithinLimits(k) && !fcl_.CollidesByTree(X_WL_) ? 1 : 0;
    }
    return free;
  }

  const PandaProblems& all_;
  const collision::QueryBody body_;
  FclRobot fcl_;
  std::vector<Pose> X_WL_;
};

planner::PlanProblem ToPlan(const PandaProblems& all, const PandaProblem& problem) {
  planner::PlanProblem plan{.joints = {}, .start = problem.start, .goal = problem.goal};
  for (std::size_t j = 0; j < all.arm->variables.size(); ++j) {
    const auto& variable =
        all.robot->model->variables[static_cast<std::size_t>(all.arm->variables[j])];
    plan.joints.push_back({.name = all.arm->joints[j],
                           .kind = planner::Joint::Kind::kLimited,
                           .lower = variable.lower,
                           .upper = variable.upper});
  }
  return plan;
}

// All states of the path, 0.01 rad apart, by FCL alone.
bool IsFreeByFcl(const planner::PlanProblem& plan, const std::vector<planner::Row>& path,
                 planner::StateChecker& fcl) {
  const planner::JointSpace space(plan.joints, 1);
  planner::EdgeBatch batch(space, fcl);
  const std::size_t start = batch.Add(path.front());
  for (std::size_t k = 1; k < path.size(); ++k) batch.Add(path[k - 1], path[k], 0.01);
  const std::size_t count = batch.size();
  if (!batch.Ask().ok()) return false;
  for (std::size_t k = start; k < count; ++k) {
    if (!batch.IsFree(k)) return false;
  }
  return path.front() == plan.start && path.back() == plan.goal;
}

struct Tally {
  std::vector<double> times_ms, finding_ms;
  int solved = 0, invalid = 0;
  double length = 0, found_length = 0, batches = 0, states = 0, rounds = 0;

  void Add(const PlanResult& result, double time_ms) {
    times_ms.push_back(time_ms);
    finding_ms.push_back(1e3 * result.finding_s);
    batches += static_cast<double>(result.asked.batches);
    states += static_cast<double>(result.asked.states);
    rounds += result.rounds;
    if (result.outcome != planner::Outcome::kSolved) return;
    ++solved;
    length += result.length;
    found_length += result.found_length;
  }

  void Describe(const std::string& who, Report& report) const {
    const double count = static_cast<double>(times_ms.size());
    char text[320];
    std::snprintf(text, sizeof(text),
                  "%s: %d of %zu solved, median %.1f ms (%.1f to find), p95 %.1f ms (%.1f), worst "
                  "%.0f ms; a problem asks %.1f batches, %.0f states, %.1f rounds; length %.2f, "
                  "%.2f as found",
                  who.c_str(), solved, times_ms.size(), Median(times_ms), Median(finding_ms),
                  Quantile(times_ms, 0.95), Quantile(finding_ms, 0.95), Quantile(times_ms, 1),
                  batches / count, states / count, rounds / count, length / std::max(1, solved),
                  found_length / std::max(1, solved));
    report.Detail(text);
  }
};

// Of a plan and its time.
std::optional<PlanResult> Plan(const planner::PlanProblem& problem, planner::StateChecker& checker,
                               const planner::PlanOptions& options, Tally& tally) {
  const auto start = std::chrono::steady_clock::now();
  const auto result = PlanMotion(problem, checker, options);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  if (!result.ok()) return std::nullopt;
  tally.Add(*result, took.count());
  return *result;
}

}  // namespace

void MeasurePlanner(const PlannerMeasure& measure, Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) return report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
  const RunningServer server;
  if (!server.up()) return report.Fail("no server");
  Tally ours, rival;
  for (std::size_t k = measure.first; k < all->problems.size(); k += measure.step) {
    const PandaProblem& problem = all->problems[k];
    const std::string world = "problem_" + std::to_string(k);
    if (const auto put = PutPandaProblem(server.connection(), problem, world); !put.ok()) {
      return report.Fail(problem.name + ": " + std::string(put.message()));
    }
    const planner::PlanProblem plan = ToPlan(*all, problem);
    FclChecker fcl(*all, problem);
    planner::ServerChecker checker(server.connection(),
                                   PandaIn(world, {}, v1::ROBOT_GEOMETRY_EXACT));
    const auto result = Plan(plan, checker, measure.options, ours);
    if (!result) return report.Fail(problem.name + ": the server failed");
    if (result->outcome == planner::Outcome::kSolved && !IsFreeByFcl(plan, result->path, fcl)) {
      ++ours.invalid;
      report.Detail(problem.name + ": FCL finds the path in collision");
    }
    if (result->outcome != planner::Outcome::kSolved) report.Detail(problem.name + ": not solved");
    if (measure.beside_fcl && !Plan(plan, fcl, measure.options, rival)) {
      return report.Fail(problem.name + ": FCL failed");
    }
    v1::DeleteWorldRequest remove;
    remove.set_world(world);
    const auto removed = server.connection().Call(&v1::WorldService::Stub::DeleteWorld,
                                                  server.connection().worlds(), remove);
    if (!removed.ok()) return report.Fail(std::string(removed.status().message()));
  }
  ours.Describe("the server", report);
  if (measure.beside_fcl) rival.Describe("FCL in process", report);
}

}  // namespace cwm::benchmarks
