// A plan as JSON; README.md documents the schema.
#pragma once

#include <string>

#include "clients/grasp/plan_grasps.h"

namespace cwm::grasp {

std::string PlanJson(const Plan& plan, const PlanRequest& request);

}  // namespace cwm::grasp
