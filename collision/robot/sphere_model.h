// A robot as spheres, which some planners check instead of the links' shapes.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

struct LinkSphere {
  Vector3 center_L = Vector3::Zero();  // in the link's frame
  double radius_m = 0;
};

// Spheres by index of the model's links, in the given order; a link may have none.
struct SphereModel {
  std::vector<std::vector<LinkSphere>> links;
};

// The spheres of a "spherized" URDF: a description of the same links whose collision geometry
// consists of spheres. Links are matched by name, and their frames are assumed to be the same;
// joints are ignored. The spheres need not contain the links' shapes. Refuses other shapes, and
// links that the model does not have.
absl::StatusOr<SphereModel> SphereModelFromUrdf(const RobotDescription& spherized,
                                                const RobotModel& model);

}  // namespace cwm::collision
