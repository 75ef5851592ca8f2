// Prints plans for people and programs.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>

#include "clients/planner/path_queries.h"
#include "clients/planner/plan_motion.h"
#include "clients/planner/planned_group.h"
#include "clients/planner/planning_world.h"

namespace cwm::planner {

struct PlanReport {
  const PlanningWorld& world;
  const PlannedGroup& group;
  const PlanResult& result;
  std::string reason = {};  // why an end of the path is invalid
  std::optional<Certificate> certificate = {};
  std::size_t goal_count = 1;  // states, any of which is the goal
  std::string tool_link = {};  // of a goal that is a pose
};

// E.g. "start in collision: panda_hand meets shelf", or "solved".
std::string Summary(const PlanReport& report);
void PrintTable(const PlanReport& report, std::ostream& out);
// The names of the fields are a contract, documented in README.md.
void PrintJson(const PlanReport& report, std::ostream& out);

}  // namespace cwm::planner
