// Further queries about a plan: why a state is in collision, and whether a path is free between its
// states.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/query_stream.h"
#include "clients/planner/joint_space.h"
#include "cwm/v1/query.pb.h"

namespace cwm::planner {

// "panda_hand meets shelf", "panda_link7 meets panda_link5 of the robot itself". `query` is made
// by MakeStateQuery.
absl::StatusOr<std::string> DescribeCollision(client::QueryStream& stream,
                                              v1::CheckCollisionsRequest query, const Row& row);

// The verdict of CheckMotions for the motion from row to row, which does not depend on samples.
struct Certificate {
  v1::MotionVerdict verdict = v1::MOTION_VERDICT_UNSPECIFIED;
  double clearance_m = 0;  // FREE: the least distance of any pair above its margin; up to 0.02
  int segment = 0;         // otherwise: from this row of the path to the next
  std::string contact;     // as above; empty if no pair is named
  v1::Trust accuracy = v1::TRUST_UNSPECIFIED;  // accuracy of the verdict
};
absl::StatusOr<Certificate> CertifyPath(client::QueryStream& stream,
                                        const v1::CheckCollisionsRequest& query,
                                        const std::vector<Row>& path);

}  // namespace cwm::planner
