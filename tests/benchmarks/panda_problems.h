// The 700 planning problems of MotionBenchMaker for the Franka Panda, which the repository does not
// contain.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/world/world_robot.h"
#include "collision/world/world_snapshot.h"

namespace cwm::benchmarks {

struct PandaProblem {
  std::string name;  // "box_panda/0001"
  std::shared_ptr<const collision::WorldSnapshot> world;
  std::vector<double> start, goal;  // of the group panda_arm
};

struct PandaProblems {
  std::shared_ptr<const collision::RobotGeometry> robot;  // with the SRDF and the 59 spheres given
  const collision::JointGroup* arm = nullptr;             // panda_arm, of robot->model
  std::vector<PandaProblem> problems;
};

// Empty if motion_bench_maker is not in CWM_DATA or is not laid out as its README says.
std::optional<PandaProblems> ReadPandaProblems();

// States of the arm for one problem, row by row: every other one uniformly random within the
// limits, the others within 0.1 rad of the goal on each joint. The same seed gives the same states.
std::vector<double> RandomStates(const PandaProblems& all, const PandaProblem& problem,
                                 std::size_t count, std::uint64_t seed);

}  // namespace cwm::benchmarks
