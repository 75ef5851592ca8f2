// What all queries about a plan have in common.
#pragma once

#include "cwm/queries.h"
#include "cwm/world.h"

namespace cwm::planner {

// States of a group of a robot, at one revision or in a scene that replaces it.
struct StateQuery {
  api::WorldView world;  // over a stream, which keeps its snapshot
  api::RobotSubject robot = {};
  api::QueryOptions options = {};
};

}  // namespace cwm::planner
