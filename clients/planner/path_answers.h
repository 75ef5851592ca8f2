// What a server says of a plan beside which states are free: why one is not, and whether a path is
// free between its states.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/query_stream.h"
#include "clients/planner/joint_space.h"
#include "cwm/v1/query.pb.h"

namespace cwm::planner {

// "panda_hand meets shelf", "panda_link7 meets panda_link5 of the robot itself". The question is
// that of QuestionOf.
absl::StatusOr<std::string> WhatCollides(client::QueryStream& stream,
                                         v1::CheckCollisionsRequest question, const Row& row);

// Of the motion from row to row, which no sample decides.
struct Certificate {
  v1::MotionVerdict verdict = v1::MOTION_VERDICT_UNSPECIFIED;
  double clearance_m = 0;   // FREE: no pair comes nearer to its margin; told up to 0.02
  int segment = 0;          // else: from this row of the path to the next
  std::string what_is_met;  // as above; empty where no pair is named
  v1::Trust trust = v1::TRUST_UNSPECIFIED;  // of the verdict
};
absl::StatusOr<Certificate> Certify(client::QueryStream& stream,
                                    const v1::CheckCollisionsRequest& question,
                                    const std::vector<Row>& path);

}  // namespace cwm::planner
