// Questions of motion planners: inverse kinematics beside KDL, and certified edges of robots with
// exact geometry and of robots of spheres.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "collision/inverse_kinematics/pose_solver.h"
#include "collision/motion/check_motions.h"
#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmark_arms.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_problems.h"
#ifdef CWM_HAS_KDL
#include "tests/benchmarks/kdl_solver.h"
#endif

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr int kPoses = 2'000;
constexpr double kKdlBudget_s = 1e-3;
constexpr double kTolerance = 1e-5;
constexpr int kEdges = 200, kSphereEdges = 1'000;
constexpr int kSamples = 33, kFineSamples = 1'024;

// Processor time of this thread alone, whatever else runs on the machine.
double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / std::max<double>(1, static_cast<double>(values.size()));
}

// States of a group, uniformly random within its limits.
class StateDraws {
 public:
  StateDraws(const RobotModel& model, const JointGroup& group, unsigned seed)
      : model_(model), group_(group), random_(seed) {}

  std::vector<double> Next() {
    std::vector<double> row;
    for (const int v : group_.variables) {
      const Variable& variable = model_.variables[static_cast<std::size_t>(v)];
      const bool is_endless = std::isinf(variable.lower) || std::isinf(variable.upper);
      row.push_back(is_endless ? Between(-std::numbers::pi, std::numbers::pi)
                               : Between(variable.lower, variable.upper));
    }
    return row;
  }
  // A state whose joints differ from those of `from` by a vector of length 1, within the limits.
  std::vector<double> OneRadianFrom(const std::vector<double>& from) {
    std::normal_distribution<double> normal;
    std::vector<double> to = from;
    double length = 0;
    for (double& value : to) {
      const double step = normal(random_);
      value = step;
      length += step * step;
    }
    for (std::size_t k = 0; k < to.size(); ++k) {
      const Variable& variable = model_.variables[static_cast<std::size_t>(group_.variables[k])];
      to[k] = std::clamp(from[k] + to[k] / std::sqrt(length), variable.lower, variable.upper);
    }
    return to;
  }

 private:
  double Between(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(random_);
  }

  const RobotModel& model_;
  const JointGroup& group_;
  std::mt19937 random_;
};

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

// A world of boxes in reach of an arm.
std::shared_ptr<const WorldSnapshot> BoxesAround(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi),
      reach(0.45, 0.9), height(-0.2, 0.9);
  std::vector<Change> changes;
  for (int k = 0; k < count; ++k) {
    const double at = angle(random), far = reach(random);
    PutObject put;
    put.name = "box" + std::to_string(k);
    put.X_WO = MakeTranslation(far * std::cos(at), far * std::sin(at), height(random));
    put.geometry = BodyFromShapes({{.shape = Box{{0.1, 0.1, 0.15}}}}).geometry;
    changes.push_back({.what = std::move(put), .expected_object_revision = {}});
  }
  return *Apply(std::make_shared<const WorldSnapshot>(), changes);
}

// Edges of one radian from free states.
struct EdgeTally {
  std::vector<double> ms;
  int contacts = 0, undecided = 0, false_free = 0;
  double sampled_s = 0, certified_s = 0;
};

struct EdgeTask {
  std::string name;
  const RobotModel& model;
  const JointGroup& group;
  const QueryBody& body;
  const WorldSnapshot& world;
  int edges = kEdges;
};

bool IsFree(const EdgeTask& task, const std::vector<double>& rows) {
  const JointRows states(task.model, task.group,
                         {.base = DefaultVariables(task.model), .rows = rows});
  const auto columns =
      CheckCollisions(task.world, task.body, states, {.naming = Naming::kWhereTested});
  return std::ranges::all_of(columns->verdict, [](Verdict v) { return v == Verdict::kFree; });
}

std::vector<double> Between(const std::vector<double>& from, const std::vector<double>& to,
                            int samples) {
  std::vector<double> rows;
  for (int k = 0; k < samples; ++k) {
    const double share = static_cast<double>(k) / (samples - 1);
    for (std::size_t v = 0; v < from.size(); ++v) rows.push_back(std::lerp(from[v], to[v], share));
  }
  return rows;
}

EdgeTally EdgesOf(const EdgeTask& task) {
  StateDraws draws(task.model, task.group, 23);
  EdgeTally tally;
  while (std::ssize(tally.ms) < task.edges) {
    const std::vector<double> from = draws.Next();
    if (!IsFree(task, from)) continue;
    const std::vector<double> to = draws.OneRadianFrom(from);
    std::vector<double> ends = from;
    ends.insert(ends.end(), to.begin(), to.end());
    const JointRows rows(task.model, task.group,
                         {.base = DefaultVariables(task.model), .rows = ends});
    const std::vector<double> samples = Between(from, to, kSamples);
    double start_s = ThreadSeconds();
    IsFree(task, samples);
    tally.sampled_s += ThreadSeconds() - start_s;
    start_s = ThreadSeconds();
    std::vector<std::unique_ptr<BodyMotion>> edges;
    edges.push_back(std::make_unique<JointMotion>(task.model, task.body, Pose::Identity(),
                                                  rows.State(0), rows.State(1)));
    const MotionColumns answer = *CheckMotions(task.world, task.body, edges, {});
    const double spent_s = ThreadSeconds() - start_s;
    tally.certified_s += spent_s;
    tally.ms.push_back(1e3 * spent_s);
    const MotionVerdict verdict = answer.verdict.front();
    tally.contacts += verdict == MotionVerdict::kContact;
    tally.undecided += verdict == MotionVerdict::kUndecided;
    if (verdict == MotionVerdict::kFree) {
      tally.false_free += !IsFree(task, Between(from, to, kFineSamples));
    }
  }
  return tally;
}

void AddEdges(const EdgeTask& task, const std::string& key, Report& report) {
  const EdgeTally tally = EdgesOf(task);
  char text[240];
  std::snprintf(text, sizeof(text),
                "  %-16s %d edges of 1 rad: %.2f ms in the mean, %.2f at p50, %.2f at p99, %.2f at "
                "most; %d in contact, %d undecided, %d told free of which a sample of 1024 hits",
                task.name.c_str(), task.edges, Mean(tally.ms), Quantile(tally.ms, 0.5),
                Quantile(tally.ms, 0.99), Quantile(tally.ms, 1), tally.contacts, tally.undecided,
                tally.false_free);
  report.Detail(text);
  report.Add({.key = key, .value = Mean(tally.ms), .unit = "ms", .how = "mean of the edges"});
  report.Add({.key = key + "_p99",
              .value = Quantile(tally.ms, 0.99),
              .unit = "ms",
              .how = "of the same edges"});
  report.Add({.key = key + "_false",
              .value = static_cast<double>(tally.false_free),
              .unit = "edges",
              .how = "told free, though one of 1 024 samples collides"});
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

void MeasureEdges(Report& report) {
  const auto world = BoxesAround(12, 3);
  const auto add = [&](const std::string& name, const std::shared_ptr<const RobotModel>& model,
                       const JointGroup& group) {
    const auto robot = PrepareRobot(model, std::nullopt);
    const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
    AddEdges({name, *model, group, body, *world}, "edge_exact_ms_" + name, report);
  };
  const BenchmarkArm six = SixJointArm(), fourteen = FourteenJointArms();
  add("six", six.model, six.model->all);
  add("fourteen", fourteen.model, fourteen.model->all);
  const std::optional<PandaProblems> panda = ReadPandaProblems();
  if (!panda) return report.Fail("edges of the Panda: motion_bench_maker is not in CWM_DATA");
  const RobotModel& model = *panda->robot->model;
  const QueryBody exact = BodyFromRobot(*panda->robot, RobotScope::kBoth);
  AddEdges({"panda", model, *panda->arm, exact, *world}, "edge_exact_ms_panda", report);
  constexpr std::size_t kFineTriangles = 40'000;
  const auto fine = WithFinerMeshes(model, kFineTriangles);
  add("panda_fine", fine, *fine->FindGroup("panda_arm"));
  const QueryBody spheres =
      BodyFromSpheres(*panda->robot, *panda->robot->prepared_spheres_as_given, RobotScope::kBoth);
  const EdgeTally tally =
      EdgesOf({"panda spheres", model, *panda->arm, spheres, *world, kSphereEdges});
  report.Add({.key = "edge_spheres_ratio",
              .value = tally.certified_s / std::max(1e-9, tally.sampled_s),
              .unit = "1",
              .how = "a certified edge of the Panda's spheres over 33 samples of it; " +
                     std::to_string(tally.false_free) + " false"});
}

}  // namespace cwm::benchmarks
