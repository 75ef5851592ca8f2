// The grasp planner: from the names of objects to ranked grasps.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/grasp/assess.h"
#include "clients/grasp/quality.h"

namespace cwm::grasp {

struct PlanRequest {
  std::string world = {};                 // empty: "default"
  std::vector<std::string> objects = {};  // empty: all that can be taken
  Gripper gripper = {};
  double friction = 0.4;
  double approach_m = 0.10;
  double clearance_m = 0.002;
  int top = 5;  // grasps kept of each object
};

struct Grasp {
  Candidate candidate = {};  // its pose is in the world
  Assessment assessment = {};
  Factors factors = {};
  double score = 0;
};

struct ObjectPlan {
  cwm::v1::Object object;
  std::vector<Grasp> grasps = {};  // the best first
  std::int64_t free_count = 0;     // of which those are the best
  std::int64_t tried_count = 0;
  std::map<std::string, std::int64_t> blocked_by = {};  // candidates by what was in their way
  std::string why = {};  // there is no grasp; empty where there is one
};

struct Plan {
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<ObjectPlan> objects;  // by name
};

// INVALID_ARGUMENT names the option at fault, or the object that cannot be taken (a support, unseen
// space, one without bounds); NOT_FOUND an unknown one, with the name that is nearest to it. All is
// asked of the revision that the objects were read from.
absl::StatusOr<Plan> PlanGrasps(const client::Connection& connection, const PlanRequest& request);

absl::Status Validate(const PlanRequest& request);

// What the grasps are asked by; of a plan, its revision.
Question QuestionOf(const PlanRequest& request, const Plan& plan);

}  // namespace cwm::grasp
