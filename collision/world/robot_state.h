// States of a robot by the names of its joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// The value of a variable, rad or m.
struct VariableValue {
  std::string variable;
  double value = 0;
};

// Where joints are to be: first a state that the SRDF names, then single variables.
struct JointValues {
  struct Named {
    std::string group;
    std::string state;
  };
  std::optional<Named> named;
  std::vector<VariableValue> values;
};

// `state`, one value for each variable of the model, with `joints` set; what they do not name stays.
// Fixed joints may be named with 0, joints that follow others with the value that they then have
// (within kFollowerTolerance, mimic.h): reports of a whole robot name them. Limits are not looked at.
//
// Refuses (FieldRuleOf: "group", "named_state", "values", "values[2].variable", "values[2].value")
// unknown groups, states and variables, variables named twice, values that are not finite or beyond
// kLargestCoordinate_m, and quaternions of floating joints of a length not within 1 % of 1.
absl::StatusOr<std::vector<double>> StateWith(const RobotModel& model, std::vector<double> state,
                                              const JointValues& joints);

// One finite value for each variable.
bool IsState(const RobotModel& model, const std::vector<double>& state);

}  // namespace cwm::collision
