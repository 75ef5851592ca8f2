// Plans a motion of joints from one row to another, or to any of several.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/planner/batch_connect.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/path_shortening.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

struct PlanProblem {
  std::vector<Joint> joints;
  Row start;
  std::vector<Row> goals;  // at least one; the path ends at any of them
};

struct PlanOptions {
  double time_limit_s = 5;  // for finding a path; shortening takes a few more queries
  std::uint32_t seed = 1;
  ConnectOptions connect = {};
  ShorteningOptions shortening = {};
};

enum class Outcome {
  kSolved,
  kStartOutOfLimits,
  kGoalOutOfLimits,  // this and the next are about the first goal, if none of them is free
  kStartInCollision,
  kGoalInCollision,
  kGoalUnreachable,  // PlanMotion does not return it: see pose_goal.h
  kNoPath,           // none was found within the time limit
};

struct PlanResult {
  Outcome outcome = Outcome::kNoPath;
  std::optional<std::size_t> joint = {};  // the joint that is out of limits
  std::vector<Row> path = {};             // if solved: from start to a goal, both included
  double length = 0, found_length = 0;    // of the path, and before shortening
  double finding_s = 0, shortening_s = 0;
  int rounds = 0;
  CheckCounts checks = {};
};

// The same problem, options and answers give the same path unless the time limit ends the search.
// The whole path is checked at kFineStep. Errors are the checker's, or INVALID_ARGUMENT for an
// invalid problem: rows of another width, numbers that are not finite, lower limits above upper
// ones.
absl::StatusOr<PlanResult> PlanMotion(const PlanProblem& problem, StateChecker& checker,
                                      const PlanOptions& options);

}  // namespace cwm::planner
