// The Panda as the 59 spheres given with it, in the scenes of MotionBenchMaker: verdicts per second
// of the SIMD kernel beside the scalar path in double precision, and whether they agree.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "collision/query/robot_body.h"
#include "collision/query/sphere_check.h"
#include "collision/robot/kinematics.h"
#include "collision/spheres/sphere_lanes.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/panda_problems.h"
#include "tests/collision/query/plain_rows.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr std::size_t kStatesPerProblem = 4000, kAtOnce = 1000;

struct Tally {
  std::size_t states = 0, colliding = 0, mismatches = 0, undecided = 0;
  double set_up_s = 0, core_s = 0, lanes_s = 0, plain_s = 0;
};

// Processor time of this thread alone, whatever else runs on the machine.
double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void Compare(const PandaProblems& all, const QueryBody& body, const PandaProblem& problem,
             std::uint64_t seed, Tally& tally) {
  const std::vector<double> states = RandomStates(all, problem, kStatesPerProblem, seed);
  const JointRows rows(*all.robot->model, *all.arm,
                       {.base = DefaultVariables(*all.robot->model), .rows = states});
  double start_s = ThreadSeconds();
  std::optional<SphereCheck> core = SphereCheck::Make(*problem.world, body, rows, {});
  tally.set_up_s += ThreadSeconds() - start_s;
  for (std::size_t first = 0; first < rows.size(); first += kAtOnce) {
    start_s = ThreadSeconds();
    const std::span<const Verdict> verdicts = core->Check(first, kAtOnce);
    tally.core_s += ThreadSeconds() - start_s;
    tally.undecided += static_cast<std::size_t>(std::ranges::count(verdicts, Verdict::kUndecided));
  }
  start_s = ThreadSeconds();
  const CollisionColumns in_lanes =
      *CheckCollisions(*problem.world, body, rows, {.naming = Naming::kWhereTested});
  tally.lanes_s += ThreadSeconds() - start_s;
  start_s = ThreadSeconds();
  const CollisionColumns plain = *CheckCollisions(*problem.world, body, PlainRows(rows), {});
  tally.plain_s += ThreadSeconds() - start_s;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const bool collides = plain.verdict[k] == Verdict::kCollision;
    tally.colliding += collides ? 1 : 0;
    tally.mismatches += in_lanes.verdict[k] != plain.verdict[k] ? 1 : 0;
  }
  tally.states += rows.size();
}

}  // namespace

void MeasureSpheres(Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) {
    report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
    return;
  }
  const QueryBody body =
      BodyFromSpheres(*all->robot, *all->robot->prepared_spheres_as_given, RobotScope::kBoth);
  Tally tally;
  for (std::size_t k = 0; k < all->problems.size(); ++k) {
    Compare(*all, body, all->problems[k], k, tally);
  }
  const double states = static_cast<double>(tally.states);
  char text[320];
  std::snprintf(
      text, sizeof(text),
      "%zu states of the Panda's %zu given spheres in %zu scenes, %.1f %% in collision, one "
      "thread, %s: core %.3f us a state, %zu left undecided, set-up %.1f us a scene; whole "
      "questions %.3f us a state, plainly %.2f us",
      tally.states, body.geometry->parts.size(), all->problems.size(),
      100 * static_cast<double>(tally.colliding) / states, LaneTarget(),
      1e6 * tally.core_s / states, tally.undecided,
      1e6 * tally.set_up_s / static_cast<double>(all->problems.size()),
      1e6 * tally.lanes_s / states, 1e6 * tally.plain_s / states);
  report.Detail(text);
  report.Add({.key = "panda_core_us",
              .value = 1e6 * tally.core_s / states,
              .unit = "us",
              .baseline = "plain path, double precision",
              .baseline_value = 1e6 * tally.plain_s / states,
              .ratio = tally.plain_s / tally.core_s,
              .how = "verdict of a state against scene and self, 59 given spheres, in process, one "
                     "thread, 1000 states at once; half uniformly random, "
                     "half within 0.1 rad of the goals"});
  report.Add({.key = "panda_core_mismatches",
              .value = static_cast<double>(tally.mismatches),
              .unit = "states",
              .how = "of the same states, verdicts other than the plain path's"});
}

}  // namespace cwm::benchmarks
