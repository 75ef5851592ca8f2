// States of a robot, by the names of its joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// The value of a variable, in rad or m.
struct VariableValue {
  std::string variable;
  double value = 0;
};

// The values of joints: first a state named in the SRDF, then single variables, which override it.
struct JointValues {
  struct Named {
    std::string group;
    std::string state;
  };
  std::optional<Named> named;
  std::vector<VariableValue> values;
};

// Returns `state`, which has one value for each variable of the model, changed by `joints`.
// Variables that are not named keep their value. Fixed joints may be named with 0, and mimic joints
// with the value that they then have (within kMimicTolerance, mimic.h), because reports of a
// whole robot name them. Limits are not checked.
//
// Refuses (FieldRuleOf: "group", "named_state", "values", "values[2].variable", "values[2].value")
// unknown groups, states and variables, variables named twice, values that are not finite or beyond
// kMaxCoordinate_m, and quaternions of floating joints whose length is not within 1 % of 1.
absl::StatusOr<std::vector<double>> StateWith(const RobotModel& model, std::vector<double> state,
                                              const JointValues& joints);

// True if there is one value for each variable, at most kMaxCoordinate_m in magnitude.
bool IsState(const RobotModel& model, const std::vector<double>& state);

}  // namespace cwm::collision
