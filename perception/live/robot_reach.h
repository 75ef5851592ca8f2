// Bounds of where the links of a robot can be in any state.
#pragma once

#include <limits>
#include <span>

#include "perception/live/robot_surface.h"

namespace cwm::perception {

struct ReachSphere {
  Vector3 center = Vector3::Zero();
  double radius_m = std::numeric_limits<double>::infinity();
};

// The joint above a link.
struct ReachJoint {
  int parent = -1;               // less than the link's own index; -1 for the root
  Pose X_PL = Pose::Identity();  // of the link in its parent, with the joint at zero
  bool moves = false;            // false: fixed
  // By how much the joint can shift the link's origin in its parent: 0 for joints that only turn,
  // infinite for floating ones.
  double travel_m = 0;
};

// A sphere in the root link's frame that holds all links in every state, about the first joint that
// moves: no state takes the robot farther from it than its rigid bodies laid in a line. One joint
// per link. Links without geometry add nothing. Infinite if a joint's travel is.
ReachSphere ReachOf(const RobotSurface& surface, std::span<const ReachJoint> joints);

}  // namespace cwm::perception
