// The motion planner on the 700 problems of MotionBenchMaker, with states checked by a running
// server and by FCL in process.

// The shapes of FCL's scenes are those of collision/geometry; the client's are in cwm::api.
#define CWM_QUALIFIED_NAMES

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/planner/path_queries.h"
#include "clients/planner/plan_motion.h"
#include "clients/planner/server_checker.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmarks.h"
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
  absl::StatusOr<std::vector<std::uint8_t>> Evaluate(std::span<const double> rows,
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
  planner::PlanProblem plan{.joints = {}, .start = problem.start, .goals = {problem.goal}};
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

// True if FCL alone finds all states of the path free, 0.01 rad apart.
bool IsFreeByFcl(const planner::PlanProblem& plan, const std::vector<planner::Row>& path,
                 planner::StateChecker& fcl) {
  const planner::JointSpace space(plan.joints, 1);
  planner::EdgeBatch batch(space, fcl);
  const std::size_t start = batch.Add(path.front());
  for (std::size_t k = 1; k < path.size(); ++k) batch.Add(path[k - 1], path[k], 0.01);
  const std::size_t count = batch.size();
  if (!batch.CheckAll().ok()) return false;
  for (std::size_t k = start; k < count; ++k) {
    if (!batch.IsFree(k)) return false;
  }
  return path.front() == plan.start && path.back() == plan.goals.front();
}

struct Tally {
  std::vector<double> times_ms, finding_ms;
  int solved = 0;
  double length = 0, found_length = 0, batches = 0, states = 0, rounds = 0;

  void Add(const PlanResult& result, double time_ms) {
    times_ms.push_back(time_ms);
    finding_ms.push_back(1e3 * result.finding_s);
    batches += static_cast<double>(result.checks.batches);
    states += static_cast<double>(result.checks.states);
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

// Plans a motion and adds its time to the tally; empty if the checker failed.
std::optional<PlanResult> Plan(const planner::PlanProblem& problem, planner::StateChecker& checker,
                               const planner::PlanOptions& options, Tally& tally) {
  const auto start = std::chrono::steady_clock::now();
  const auto result = PlanMotion(problem, checker, options);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  if (!result.ok()) return std::nullopt;
  tally.Add(*result, took.count());
  return *result;
}

// Motion certificates of paths that were checked state by state: the server's verdicts on the space
// in between.
struct Certificates {
  int free = 0, contact = 0, undecided = 0;
  std::vector<double> times_ms;

  absl::Status Add(const planner::StateQuery& query, const std::vector<planner::Row>& path) {
    const auto start = std::chrono::steady_clock::now();
    const auto certificate = planner::CertifyPath(query, path);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    if (!certificate.ok()) return certificate.status();
    times_ms.push_back(took.count());
    if (certificate->verdict == api::MotionVerdict::kFree) {
      ++free;
    } else if (certificate->verdict == api::MotionVerdict::kContact) {
      ++contact;
    } else {
      ++undecided;
    }
    return absl::OkStatus();
  }
};

struct Measured {
  Tally server, fcl;
  int invalid = 0;
  Certificates certificates;
};

absl::Status MeasureProblem(const PandaProblems& all, const PandaProblem& problem,
                            const PlannerMeasure& measure, const client::Connection& connection,
                            Measured& measured, Report& report) {
  const std::string world = "planned";
  if (const auto put = PutPandaProblem(connection, problem, world); !put.ok()) return put;
  const planner::PlanProblem plan = ToPlan(all, problem);
  const planner::StateQuery query{
      .world = api::Connect({.address = connection.address(), .world = world}).Stream(),
      .robot = {.robot = "panda", .group = "panda_arm"}};
  FclChecker fcl(all, problem);
  planner::ServerChecker checker(query);
  const auto result = Plan(plan, checker, measure.options, measured.server);
  if (!result) return absl::InternalError("the server failed");
  if (result->outcome != planner::Outcome::kSolved) {
    report.Detail(problem.name + ": not solved");
  } else {
    if (!IsFreeByFcl(plan, result->path, fcl)) {
      ++measured.invalid;
      report.Detail(problem.name + ": FCL finds the path in collision");
    }
    if (measure.certify) {
      const auto status = measured.certificates.Add(query, result->path);
      if (!status.ok()) return status;
    }
  }
  if (measure.beside_fcl && !Plan(plan, fcl, measure.options, measured.fcl)) {
    return absl::InternalError("FCL failed");
  }
  v1::DeleteWorldRequest remove;
  remove.set_world(world);
  return connection.Call(&v1::WorldService::Stub::DeleteWorld, connection.worlds(), remove)
      .status();
}

void AddFigures(const Measured& measured, Report& report) {
  const std::string how =
      "the Panda in the scenes of MotionBenchMaker, meshes, robot and scene loaded before; finding "
      "and shortening by batches over one stream, client and server on the same cores; one seed";
  report.Add({.key = "mbm_solved_of_700",
              .value = static_cast<double>(measured.server.solved),
              .unit = "problems",
              .baseline = "FCL in process, same planner",
              .baseline_value = static_cast<double>(measured.fcl.solved),
              .how = how + ", at most 5 s each"});
  report.Add({.key = "mbm_median_ms",
              .value = Median(measured.server.times_ms),
              .unit = "ms",
              .baseline = "FCL in process, same planner",
              .baseline_value = Median(measured.fcl.times_ms),
              .ratio = Median(measured.fcl.times_ms) / Median(measured.server.times_ms),
              .how = how});
  report.Add(
      {.key = "mbm_p95_ms",
       .value = Quantile(measured.server.times_ms, 0.95),
       .unit = "ms",
       .baseline = "FCL in process, same planner",
       .baseline_value = Quantile(measured.fcl.times_ms, 0.95),
       .ratio = Quantile(measured.fcl.times_ms, 0.95) / Quantile(measured.server.times_ms, 0.95),
       .how = how});
  report.Add({.key = "mbm_invalid_paths",
              .value = static_cast<double>(measured.invalid),
              .unit = "paths",
              .how =
                  "of those solved: some state, 0.01 rad apart along the path, is in collision by "
                  "FCL on the meshes in process, or it does not join start and goal"});
}

}  // namespace

void MeasurePlanner(const PlannerMeasure& measure, Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) return report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
  const RunningServer server;
  if (!server.up()) return report.Fail("no server");
  Measured measured;
  for (std::size_t k = measure.first; k < all->problems.size(); k += measure.step) {
    absl::Status status;
    try {
      status =
          MeasureProblem(*all, all->problems[k], measure, server.connection(), measured, report);
    } catch (const api::Error& error) {
      status = client::StatusFromError(error);
    }
    if (!status.ok()) {
      return report.Fail(all->problems[k].name + ": " + std::string(status.message()));
    }
  }
  measured.server.Describe("the server", report);
  if (measure.beside_fcl) measured.fcl.Describe("FCL in process", report);
  if (measure.certify) {
    const Certificates& c = measured.certificates;
    char text[240];
    std::snprintf(
        text, sizeof(text),
        "certified by CheckMotions: %d free, %d in contact between states, %d undecided or "
        "grazing; median %.1f ms a path, p95 %.1f ms",
        c.free, c.contact, c.undecided, Median(c.times_ms), Quantile(c.times_ms, 0.95));
    report.Detail(text);
  }
  if (measure.step == 1 && measure.first == 0 && measure.beside_fcl) AddFigures(measured, report);
}

void MeasurePlanning(Report& report) { MeasurePlanner({}, report); }

}  // namespace cwm::benchmarks
