// Inverse kinematics by KDL, with restarts from random states.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "collision/inverse_kinematics/ik_chain.h"

namespace cwm::benchmarks {

class KdlSolver {
 public:
  explicit KdlSolver(const collision::IkChain& chain);
  ~KdlSolver();

  // Solves for the pose within 1e-5 m and rad and the limits: Levenberg and Marquardt's method from
  // the seed and then from random states, until `budget_s` has passed. Empty if it did not succeed.
  std::vector<double> Solve(const Pose& X_BT, std::span<const double> seed, double budget_s);

 private:
  struct Robot;
  std::unique_ptr<Robot> robot_;
};

}  // namespace cwm::benchmarks
