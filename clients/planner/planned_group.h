// The joints of a server's robot that a plan moves.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/scene_file.h"
#include "clients/planner/joint_space.h"
#include "cwm/v1/robot_model.pb.h"

namespace cwm::planner {

struct PlannedGroup {
  std::string name;  // empty: all joints of the robot
  std::vector<Joint> joints;
  Row current;  // the robot's present values
};

// INVALID_ARGUMENT with the names of the groups if there is none of that name, and with the joint
// if one cannot be planned for: planar and floating joints, and others without limits.
absl::StatusOr<PlannedGroup> ReadPlannedGroup(const v1::Robot& robot, const std::string& name);

// A state that the SRDF names, of the group or, for all joints, of any group; joints that it does
// not name are as in `current`. INVALID_ARGUMENT with the names of the states, or of the groups if
// several have it.
absl::StatusOr<Row> NamedState(const v1::Robot& robot, const PlannedGroup& group,
                               const std::string& name);

// The row with these joints' values; joints outside of the group are ignored.
Row WithJoints(const PlannedGroup& group, Row row, const std::vector<formats::SceneJoint>& joints);

// A row from values of exactly the group's joints. INVALID_ARGUMENT with the joint that is missing
// or not in the group.
absl::StatusOr<Row> RowOfAllJoints(const PlannedGroup& group,
                                   const std::vector<formats::SceneJoint>& joints);

}  // namespace cwm::planner
