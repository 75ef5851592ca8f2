// The exit codes of the command line.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace cwm::cli {

enum class ExitCode {
  kDone = 0,
  kUsage = 1,
  kUnavailable = 2,
  kNotFound = 3,
  kConflict = 4,  // aborted, failed precondition, out of range
  kDeadline = 5,  // deadline or cancelled
  kPermission = 6,
  kExhausted = 7,
  kBadInput = 8,
  // Only with --exit-code; then kDone means that everything is free.
  kCollision = 10,  // at least one row is in collision
  kNotFree = 11,    // no collision, but not everything is known to be free
  kOther = 70,
};

ExitCode ExitCodeOf(const absl::Status& status);

// kUsage for an error on the command line itself; bad data in files, on stdin or refused by the
// server is kBadInput.
absl::Status UsageError(const std::string& message);
bool IsUsageError(const absl::Status& status);

}  // namespace cwm::cli
