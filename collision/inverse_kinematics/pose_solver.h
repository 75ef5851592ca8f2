// Inverse kinematics: values of a group's variables at which a tool has a given pose.
//
// Eight starts are searched at once in single precision (ik_steps.h); the first is the seed, the
// others are drawn evenly within the limits. A start that does not converge is replaced by the next
// draw. What converges is refined in double precision, and is a solution if the pose is reached
// within the tolerances and the limits. The work is bounded by steps and never by time, so that the
// same request gives the same bytes anywhere.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/inverse_kinematics/ik_chain.h"

namespace cwm::collision {

// chosen: a step of all starts of a seven-axis arm takes about half a microsecond, so that a pose
// out of reach costs about a millisecond.
inline constexpr int kIkSteps = 2000;
// Solutions are distinct if some variable differs by more than this, rad or m.
inline constexpr double kDistinctSolutions = 0.1;

struct PoseRequest {
  Pose X_BT = Pose::Identity();  // the tool in the frame of the robot's root
  double position_tolerance_m = 1e-6;
  double rotation_tolerance_rad = 1e-6;
  // A row of the group: where the search starts, and the values of variables that do not move the
  // tool. Solutions are ordered by their distance from it.
  std::span<const double> seed;
  int max_solutions = 1;
  // Searches from the seed alone, so that the solution lies on the seed's branch.
  bool same_branch = false;
  int max_steps = kIkSteps;
};

struct PoseSolution {
  std::vector<double> row;  // of the group
  double position_error_m = 0;
  double rotation_error_rad = 0;
};

struct PoseAnswer {
  std::vector<PoseSolution> solutions;  // distinct, nearest to the seed first
  // Without a solution: the least error that was met. It proves nothing about other values.
  PoseSolution nearest;
  int steps = 0;  // of all starts, each of eight at once
};

// Used by one thread at a time. Refers to the chain.
class PoseSolver {
 public:
  explicit PoseSolver(const IkChain& chain) : chain_(chain) {}

  PoseAnswer Solve(const PoseRequest& request);

 private:
  struct Search;

  const IkChain& chain_;
  std::vector<double> starts_;  // draws so far, in rows of the chain's variables
};

}  // namespace cwm::collision
