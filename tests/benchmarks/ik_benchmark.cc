// Inverse kinematics beside KDL.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "collision/inverse_kinematics/pose_solver.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmark_arms.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_problems.h"
#include "tests/benchmarks/state_draws.h"
#ifdef CWM_HAS_KDL
#include "tests/benchmarks/kdl_solver.h"
#endif

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr int kPoses = 2'000;
constexpr double kKdlBudget_s = 1e-3;
constexpr double kTolerance = 1e-5;

// One arm of the figures.
struct IkTask {
  std::string name;
  const RobotModel* model;
  const JointGroup* group;
  std::string tool;
};

struct IkTally {
  int poses = 0, solved = 0, wrong = 0, solved_by_kdl = 0;
  std::vector<double> own_us, kdl_us;
};

IkTally SolveOf(const IkTask& task) {
  const std::vector<double> base = DefaultVariables(*task.model);
  const int link = *task.model->FindLink(task.tool);
  const auto chain = MakeIkChain(*task.model, *task.group, base, link, Pose::Identity());
  IkTally tally;
  if (!chain.ok()) return tally;
  PoseSolver solver(*chain);
#ifdef CWM_HAS_KDL
  KdlSolver kdl(*chain);
#endif
  StateDraws draws(*task.model, *task.group, 11);
  std::vector<Pose> X_BL(task.model->links.size());
  const auto pose_of = [&](const std::vector<double>& row) {
    std::vector<double> variables = base;
    for (std::size_t k = 0; k < row.size(); ++k) {
      variables[static_cast<std::size_t>(task.group->variables[k])] = row[k];
    }
    LinkPoses(*task.model, Pose::Identity(), variables, X_BL);
    return X_BL[static_cast<std::size_t>(link)];
  };
  for (; tally.poses < kPoses; ++tally.poses) {
    const Pose X_BT = pose_of(draws.Next());
    const std::vector<double> seed = draws.Next();
    double start_s = ThreadSeconds();
    const PoseAnswer answer = solver.Solve({.X_BT = X_BT,
                                            .position_tolerance_m = kTolerance,
                                            .rotation_tolerance_rad = kTolerance,
                                            .seed = seed});
    tally.own_us.push_back(1e6 * (ThreadSeconds() - start_s));
    if (!answer.solutions.empty()) {
      ++tally.solved;
      const Pose X = pose_of(answer.solutions.front().row);
      const double off_rad =
          Eigen::AngleAxisd(Matrix3(X.linear().transpose() * X_BT.linear())).angle();
      const double off_m = (X.translation() - X_BT.translation()).norm();
      tally.wrong += off_m > 1.1 * kTolerance || off_rad > 1.1 * kTolerance;
    }
#ifdef CWM_HAS_KDL
    std::vector<double> of_chain;
    for (const IkVariable& variable : chain->variables) {
      of_chain.push_back(seed[static_cast<std::size_t>(variable.of_group)]);
    }
    start_s = ThreadSeconds();
    const bool is_solved = !kdl.Solve(X_BT, of_chain, kKdlBudget_s).empty();
    tally.kdl_us.push_back(1e6 * (ThreadSeconds() - start_s));
    tally.solved_by_kdl += is_solved;
#endif
  }
  return tally;
}

}  // namespace

void MeasureInverseKinematics(Report& report) {
  const std::optional<PandaProblems> panda = ReadPandaProblems();
  const BenchmarkArm six = SixJointArm(), fourteen = FourteenJointArms();
  std::vector<IkTask> tasks = {
      {"six", six.model.get(), &six.model->all, six.tools[0]},
      {"left", fourteen.model.get(), &fourteen.model->all, fourteen.tools[0]}};
  if (panda) {
    tasks.push_back({"panda", panda->robot->model.get(), panda->arm, "panda_hand"});
  } else {
    report.Fail("inverse kinematics of the Panda: motion_bench_maker is not in CWM_DATA");
  }
  double worst_success = 1, worst_median_us = 0, worst_p99_us = 0;
  int wrong = 0;
  for (const IkTask& task : tasks) {
    const IkTally tally = SolveOf(task);
    const double share = static_cast<double>(tally.solved) / std::max(1, tally.poses);
    char text[240];
    std::snprintf(
        text, sizeof(text),
        "  %-8s %d poses: %.4f solved, median %.1f us, p99 %.1f us; KDL (LMA, restarts, 1 "
        "ms) %.4f, median %.1f us, p99 %.1f us",
        task.name.c_str(), tally.poses, share, Quantile(tally.own_us, 0.5),
        Quantile(tally.own_us, 0.99),
        static_cast<double>(tally.solved_by_kdl) / std::max(1, tally.poses),
        Quantile(tally.kdl_us, 0.5), Quantile(tally.kdl_us, 0.99));
    report.Detail(text);
    worst_success = std::min(worst_success, share);
    worst_median_us = std::max(worst_median_us, Quantile(tally.own_us, 0.5));
    worst_p99_us = std::max(worst_p99_us, Quantile(tally.own_us, 0.99));
    wrong += tally.wrong;
  }
  report.Add({.key = "ik_success",
              .value = worst_success,
              .unit = "1",
              .how = "reachable poses solved to 1e-5 m and rad, the worst arm"});
  report.Add({.key = "ik_wrong",
              .value = static_cast<double>(wrong),
              .unit = "poses",
              .how = "solutions that forward kinematics does not confirm"});
  report.Add(
      {.key = "ik_us", .value = worst_median_us, .unit = "us", .how = "median, the worst arm"});
  report.Add(
      {.key = "ik_us_p99", .value = worst_p99_us, .unit = "us", .how = "p99, the worst arm"});
}

}  // namespace cwm::benchmarks
