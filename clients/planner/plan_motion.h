// A motion of joints from one row to another.
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
  Row start, goal;
};

struct PlanOptions {
  double time_limit_s = 5;  // for finding a path; shortening it takes a few questions more
  std::uint32_t seed = 1;
  ConnectOptions connect = {};
  ShorteningOptions shortening = {};
};

enum class Outcome {
  kSolved,
  kStartOutOfLimits,
  kGoalOutOfLimits,
  kStartInCollision,
  kGoalInCollision,
  kNoPath,  // none was found in the time given
};

struct PlanResult {
  Outcome outcome = Outcome::kNoPath;
  std::optional<std::size_t> joint = {};  // that is out of limits
  std::vector<Row> path = {};             // solved: from the start to the goal, both included
  double length = 0, found_length = 0;    // of it, and before it was shortened
  double finding_s = 0, shortening_s = 0;
  int rounds = 0;
  Asked asked = {};
};

// The same problem, options and answers give the same path, unless the time limit ends it. The path
// has been asked at kFineStep all along. Errors are the checker's, or INVALID_ARGUMENT of a problem
// that is none: rows of another width, numbers that are not finite, limits that cross.
absl::StatusOr<PlanResult> PlanMotion(const PlanProblem& problem, StateChecker& checker,
                                      const PlanOptions& options);

}  // namespace cwm::planner
