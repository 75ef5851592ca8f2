// The motion planner on a part of the problems, or with other options.
#pragma once

#include <cstddef>

#include "clients/planner/plan_motion.h"
#include "tests/benchmarks/report.h"

namespace cwm::benchmarks {

struct PlannerMeasure {
  std::size_t first = 0, step = 1;  // of the 700 problems: 1 takes all
  bool beside_fcl = true;
  bool certify = true;
  planner::PlanOptions options = {};
};
// Adds figures only if all problems are measured beside FCL; adds details in any case.
void MeasurePlanner(const PlannerMeasure& measure, Report& report);

}  // namespace cwm::benchmarks
