// The command `cwm-plan`.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace cwm::planner {

// Exit codes besides those of `cwm`: 1 usage, 2 unavailable, 3 not found, 4 revision conflict, 5
// deadline, 6 permission, 7 exhausted, 8 bad input, 70 anything else.
enum class PlanExit {
  kSolved = 0,
  kStartInCollision = 10,
  kGoalInCollision = 11,
  kStartOutOfLimits = 12,
  kGoalOutOfLimits = 13,
  kNoPath = 14,
  kNotCertified = 15,     // only with --certify
  kGoalUnreachable = 16,  // only with --goal-at
};

int Run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace cwm::planner
