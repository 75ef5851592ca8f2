// Plans as people and programs read them.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>

#include "clients/planner/path_answers.h"
#include "clients/planner/plan_motion.h"
#include "clients/planner/planned_group.h"
#include "clients/planner/planning_world.h"

namespace cwm::planner {

struct PlanReport {
  const PlanningWorld& world;
  const PlannedGroup& group;
  const PlanResult& result;
  std::string why = {};  // what is wrong with an end
  std::optional<Certificate> certificate = {};
};

// "start in collision: panda_hand meets shelf"; of a solved one, "solved".
std::string Summary(const PlanReport& report);
void PrintTable(const PlanReport& report, std::ostream& out);
// The names of the fields are a contract: README.md lists them.
void PrintJson(const PlanReport& report, std::ostream& out);

}  // namespace cwm::planner
