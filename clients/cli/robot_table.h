// Prints robots as tables.
#pragma once

#include <google/protobuf/repeated_field.h>
#include <google/protobuf/repeated_ptr_field.h>

#include <iosfwd>
#include <string>

#include "clients/cli/table.h"
#include "cwm/v1/robot_model.pb.h"

namespace cwm::cli {

// One line per robot: its parts and its pose.
void PrintRobots(const google::protobuf::RepeatedPtrField<cwm::v1::Robot>& robots, TableStyle style,
                 std::ostream& out);

// That line, the robot's links, its variables with limits and values, and its groups.
void PrintRobotDetails(const cwm::v1::Robot& robot, TableStyle style, std::ostream& out);

// E.g. "0.000 -0.785 1.571".
std::string FormatJoints(const google::protobuf::RepeatedField<double>& values);

}  // namespace cwm::cli
