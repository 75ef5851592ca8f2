// What a robot's description gets wrong about its self collisions, found by sampling states.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/world/world_robot.h"

namespace cwm::collision {

struct SelfCollisions {
  // The checked pairs of links that collide in every sampled state: no state of the robot can be
  // free. Empty if the work ran out before all states were sampled.
  std::vector<LinkPair> always;
  // A state in which another pair of links collides, one that joints of its group move relative to
  // each other: a state of a hand says nothing about the arm.
  struct InState {
    std::string group, state;  // of a named state; both are empty for the given state
    LinkPair links;            // the first such pair
  };
  std::vector<InState> states;  // the given state first, then in the order of groups and states
};

// Samples kSampledStates states, the same for each call, uniformly within the limits of the
// variables (a turn or a metre to either side where there are none), and tests `initial_state` and
// all named states, with the other variables at their defaults. Exact for the shapes of the links.
// Takes well below 100 ms: it counts its work, never the time, and then leaves out what is missing.
// nullopt if `work` ended it.
inline constexpr int kSampledStates = 256;
std::optional<SelfCollisions> FindSelfCollisions(const RobotGeometry& robot,
                                                 std::span<const double> initial_state,
                                                 WorkCounter* work = nullptr);

}  // namespace cwm::collision
