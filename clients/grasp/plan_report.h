// A plan as JSON; the schema is told in README.md.
#pragma once

#include <string>

#include "clients/grasp/plan_grasps.h"

namespace cwm::grasp {

std::string PlanJson(const Plan& plan, const PlanRequest& request);

}  // namespace cwm::grasp
