// Arms of other kinds than the Panda: six joints with large meshes, and two arms of seven joints.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "collision/robot/robot_model.h"

namespace cwm::benchmarks {

struct BenchmarkArm {
  std::shared_ptr<const collision::RobotModel> model;
  std::vector<std::string> tools;  // links at the ends
};

// Six joints: an offset shoulder and elbow and a wrist of three crossing axes, links of 20 000
// triangles or more, among them long slivers.
BenchmarkArm SixJointArm();
// Two arms of seven joints on one post, links of some hundred triangles.
BenchmarkArm FourteenJointArms();

// The robot with the triangles of its meshes split in four until each has at least so many.
std::shared_ptr<const collision::RobotModel> WithFinerMeshes(const collision::RobotModel& robot,
                                                             std::size_t triangles);

}  // namespace cwm::benchmarks
