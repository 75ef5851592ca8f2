// Further queries about a plan: why a state is in collision, and whether a path is free between its
// states.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/state_query.h"

namespace cwm::planner {

// "panda_hand meets shelf", "panda_link7 meets panda_link5 of the robot itself".
absl::StatusOr<std::string> DescribeCollision(const StateQuery& query, const Row& row);

// The verdict of the motion from row to row, which does not depend on samples.
struct Certificate {
  api::MotionVerdict verdict = api::MotionVerdict::kNotComputed;
  double clearance_m = 0;  // FREE: the least distance of any pair above its margin; up to 0.02
  int segment = 0;         // otherwise: from this row of the path to the next
  std::string contact;     // as above; empty if no pair is named
  api::Trust accuracy = api::Trust::kNone;  // of the verdict
};
absl::StatusOr<Certificate> CertifyPath(const StateQuery& query, const std::vector<Row>& path);

}  // namespace cwm::planner
