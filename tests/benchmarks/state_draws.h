// Random states of robots, and the time that a thread spends on them.
#pragma once

#include <random>
#include <vector>

#include "collision/robot/robot_model.h"

namespace cwm::benchmarks {

// Processor time of this thread alone, whatever else runs on the machine.
double ThreadSeconds();

double Mean(const std::vector<double>& values);

// States of a group, uniformly random within its limits. Refers to model and group.
class StateDraws {
 public:
  StateDraws(const collision::RobotModel& model, const collision::JointGroup& group, unsigned seed)
      : model_(model), group_(group), random_(seed) {}

  std::vector<double> Next();
  // A state whose joints differ from those of `from` by a vector of length 1, within the limits.
  std::vector<double> OneRadianFrom(const std::vector<double>& from);

 private:
  double Between(double lower, double upper);

  const collision::RobotModel& model_;
  const collision::JointGroup& group_;
  std::mt19937 random_;
};

}  // namespace cwm::benchmarks
