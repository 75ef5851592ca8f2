// Robots for people.
#pragma once

#include <google/protobuf/repeated_field.h>
#include <google/protobuf/repeated_ptr_field.h>

#include <iosfwd>
#include <string>

#include "clients/cli/table.h"
#include "cwm/v1/robot_model.pb.h"

namespace cwm::cli {

// A line a robot: what it is made of and where it stands.
void PrintRobots(const google::protobuf::RepeatedPtrField<cwm::v1::Robot>& robots, TableStyle style,
                 std::ostream& out);

// That line, its links, its variables with limits and values, its groups.
void PrintRobotDetails(const cwm::v1::Robot& robot, TableStyle style, std::ostream& out);

// "0.000 -0.785 1.571"
std::string JointText(const google::protobuf::RepeatedField<double>& values);

}  // namespace cwm::cli
