// Verdicts of FCL on the Panda's meshes that differ from the exact engine's, over a million states
// of which many are next to contact, and the reasons.
#include <array>
#include <cstdio>
#include <vector>

#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/contact_states.h"
#include "tests/benchmarks/difference_explainer.h"
#include "tests/benchmarks/fcl_robot.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

constexpr std::size_t kStates = 1000000;
struct Tally {
  std::size_t states = 0, colliding = 0, near = 0, different = 0;
  std::array<std::size_t, 4> by_reason = {};
};

void Compare(const PandaProblems& all, const PandaProblem& problem, std::size_t count,
             std::uint64_t seed, Tally& tally) {
  const QueryBody body = BodyFromRobot(*all.robot, RobotScope::kBoth);
  const ContactStates states = StatesAboutContact(all, problem, count, seed);
  const JointRows rows(*all.robot->model, *all.arm,
                       {.base = DefaultVariables(*all.robot->model), .rows = states.rows});
  const CollisionColumns columns = *CheckCollisions(*problem.world, body, rows, {});
  FclRobot fcl(body, *problem.world);
  const DifferenceExplainer explainer(body, *problem.world, fcl);
  std::vector<Pose> X_WL(all.robot->model->links.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows.Place(k, X_WL);
    const bool ours = columns.verdict[k] == Verdict::kCollision;
    ++tally.states;
    tally.colliding += ours ? 1 : 0;
    tally.near += states.is_near[k];
    if (fcl.CollidesPlainly(X_WL) == ours) continue;
    ++tally.different;
    ++tally.by_reason[static_cast<std::size_t>(explainer.Explain(X_WL))];
  }
}

}  // namespace

void MeasureUnexplained(Report& report) {
  const std::optional<PandaProblems> all = ReadPandaProblems();
  if (!all) {
    report.Detail("skipped: motion_bench_maker is not in CWM_DATA");
    return;
  }
  const std::size_t each = (kStates + all->problems.size() - 1) / all->problems.size();
  Tally tally;
  for (std::size_t k = 0; k < all->problems.size(); ++k) {
    Compare(*all, all->problems[k], each, k, tally);
  }
  const auto of = [&](DifferenceCause cause) {
    return tally.by_reason[static_cast<std::size_t>(cause)];
  };
  char text[320];
  std::snprintf(
      text, sizeof(text),
      "%zu states of the Panda's meshes in %zu scenes, %zu in collision, %zu within %g mm of "
      "contact: FCL tells otherwise of %zu, %zu of them one part inside of another, %zu with a "
      "point "
      "of a triangle in the other solid, %zu within %g m of touching",
      tally.states, all->problems.size(), tally.colliding, tally.near, 1e3 * kNextToContact_m,
      tally.different, of(DifferenceCause::kContained), of(DifferenceCause::kShared),
      of(DifferenceCause::kTouching), kTouching_m);
  report.Detail(text);
  report.Add(
      {.key = "mbm_unexplained",
       .value = static_cast<double>(of(DifferenceCause::kUnknown)),
       .unit = "states",
       .how =
           "verdicts other than FCL's in a million states, half in collision, a quarter "
           "next to contact, that neither containment nor a shared point nor touching explains"});
}

}  // namespace cwm::benchmarks
