// The grasp planner: from objects to ranked grasps.
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
  std::vector<std::string> objects = {};  // empty: all objects that can be grasped
  Gripper gripper = {};
  double friction = 0.4;
  double approach_m = 0.10;
  double clearance_m = 0.002;
  int top = 5;  // grasps kept per object
};

struct Grasp {
  Candidate candidate = {};  // with its pose in the world
  Assessment assessment = {};
  Factors factors = {};
  double score = 0;
};

struct ObjectPlan {
  api::Object object;
  std::vector<Grasp> grasps = {};  // the best first
  std::int64_t free_count = 0;     // before the best were selected
  std::int64_t tried_count = 0;
  std::map<std::string, std::int64_t> blocked_by = {};  // number of candidates by their obstacle
  std::string failure_reason = {};  // why there is no grasp; empty if there is one
};

struct Plan {
  std::string world;
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<ObjectPlan> objects;  // by name
};

// INVALID_ARGUMENT with the option at fault, or with the object that cannot be grasped (a support,
// unseen space, one without bounds); NOT_FOUND for an unknown object, with the most similar name;
// errors of calls. All queries are about the revision from which the objects were read.
absl::StatusOr<Plan> PlanGrasps(const api::WorldView& world, const PlanRequest& request);

absl::Status Validate(const PlanRequest& request);

// The common part of the plan's queries.
GraspQuery MakeGraspQuery(const PlanRequest& request);

}  // namespace cwm::grasp
