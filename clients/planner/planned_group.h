// The joints of a robot of the server that a plan moves.
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
  Row standing;  // where the robot has them
};

// INVALID_ARGUMENT naming the groups where there is none of the name, and naming the joint where
// one cannot be planned for: planar and floating joints, and others without limits.
absl::StatusOr<PlannedGroup> GroupOf(const v1::Robot& robot, const std::string& name);

// A state that the SRDF names, of the group, or of any where the group is all joints: joints that
// it does not name are as in `standing`. INVALID_ARGUMENT naming the states that there are, or the
// groups where several have it.
absl::StatusOr<Row> NamedState(const v1::Robot& robot, const PlannedGroup& group,
                               const std::string& name);

// The row with these joints as given, whatever else is among them.
Row With(const PlannedGroup& group, Row row, const std::vector<formats::SceneJoint>& joints);

// Every joint of the group, and no other. INVALID_ARGUMENT naming the joint that is missing or is
// none of the group.
absl::StatusOr<Row> WholeRow(const PlannedGroup& group,
                             const std::vector<formats::SceneJoint>& joints);

}  // namespace cwm::planner
