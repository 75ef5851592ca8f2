// The Panda in the scenes of MotionBenchMaker: verdicts per second beside FCL's on the same states,
// whether they agree, and the reason if it can be shown why they do not.
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/difference_explainer.h"
#include "tests/benchmarks/fcl_robot.h"
#include "tests/benchmarks/panda_problems.h"

namespace cwm::benchmarks {
namespace {

// The batch of a planner that samples states.
constexpr std::size_t kStatesPerProblem = 1000;

// Adds this thread's processor time to a sum, so that other load on the machine does not count.
class SecondsOf {
 public:
  explicit SecondsOf(double& sum_s) : sum_s_(sum_s) {}
  ~SecondsOf() { sum_s_ += Now_s() - start_s_; }
  SecondsOf(const SecondsOf&) = delete;
  SecondsOf& operator=(const SecondsOf&) = delete;

 private:
  static double Now_s() {
    timespec now = {};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  double& sum_s_;
  const double start_s_ = Now_s();
};

struct Tally {
  std::size_t states = 0, colliding = 0, mismatches = 0;
  std::vector<std::string> differences;
  double ours_s = 0, plain_s = 0, tree_s = 0;
};

std::string Describe(const PandaProblem& problem, std::size_t row, bool ours,
                     DifferenceCause cause) {
  char text[200];
  std::snprintf(text, sizeof(text), "%s, state %zu: %s, FCL says %s: %s", problem.name.c_str(), row,
                ours ? "in collision" : "free", ours ? "free" : "in collision",
                std::string(NameOf(cause)).c_str());
  return text;
}

void Compare(const PandaProblems& all, const PandaProblem& problem, std::uint64_t seed,
             Tally& tally) {
  using namespace collision;
  const QueryBody body = BodyFromRobot(*all.robot, RobotScope::kBoth);
  const std::vector<double> states = RandomStates(all, problem, kStatesPerProblem, seed);
  const JointRows rows(*all.robot->model, *all.arm,
                       {.base = DefaultVariables(*all.robot->model), .rows = states});
  FclRobot fcl(body, *problem.world);
  const DifferenceExplainer explainer(body, *problem.world, fcl);
  std::vector<Pose> X_WL(all.robot->model->links.size());
  CollisionColumns columns;
  {
    const SecondsOf timed(tally.ours_s);
    columns = *CheckCollisions(*problem.world, body, rows, {});
  }
  std::vector<char> plain(rows.size()), by_tree(rows.size());
  {
    const SecondsOf timed(tally.plain_s);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      rows.Place(k, X_WL);
      plain[k] = fcl.CollidesPlainly(X_WL);
    }
  }
  {
    const SecondsOf timed(tally.tree_s);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      rows.Place(k, X_WL);
      by_tree[k] = fcl.CollidesByTree(X_WL);
    }
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const bool ours = columns.verdict[k] == Verdict::kCollision;
    tally.colliding += ours ? 1 : 0;
    if (ours == static_cast<bool>(plain[k]) && plain[k] == by_tree[k]) continue;
    rows.Place(k, X_WL);
    const bool is_reproduced = fcl.CollidesPlainly(X_WL) == static_cast<bool>(by_tree[k]);
    const DifferenceCause cause =
        is_reproduced ? explainer.Explain(X_WL) : DifferenceCause::kUnknown;
    tally.differences.push_back(Describe(problem, k, ours, cause));
    tally.mismatches += cause == DifferenceCause::kUnknown ? 1 : 0;
  }
  tally.states += rows.size();
}

}  // namespace

void MeasureRobots(Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) {
    report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
    return;
  }
  Tally tally;
  for (std::size_t k = 0; k < all->problems.size(); ++k) {
    Compare(*all, all->problems[k], k, tally);
  }
  const auto each_us = [&](double seconds) {
    return 1e6 * seconds / static_cast<double>(tally.states);
  };
  char text[240];
  std::snprintf(
      text, sizeof(text),
      "%zu states of the Panda's meshes in %zu scenes, %zu in collision, one thread: ours "
      "%.2f us a state, FCL in a plain loop %.2f us, FCL with its tree %.2f us",
      tally.states, all->problems.size(), tally.colliding, each_us(tally.ours_s),
      each_us(tally.plain_s), each_us(tally.tree_s));
  report.Detail(text);
  for (const std::string& difference : tally.differences) report.Detail(difference);
  report.Add(
      AsRatio({.key = "panda_exact_ratio_fcl",
               .value = each_us(tally.ours_s),
               .unit = "us",
               .baseline = "FCL, plain loop",
               .baseline_value = each_us(tally.plain_s),
               .ratio = tally.plain_s / tally.ours_s,
               .how = "verdict of a state against scene and self, meshes, in process, one thread; "
                      "half uniformly random, half within 0.1 rad of the goals"}));
  report.Add({.key = "panda_exact_mismatches",
              .value = static_cast<double>(tally.mismatches),
              .unit = "states",
              .how =
                  "of the same states, ours other than FCL's, and neither containment nor a shared "
                  "point nor touching explains it; those that are explained are listed"});
}

}  // namespace cwm::benchmarks
