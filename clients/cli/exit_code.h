// What the command line answers to the shell.
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
  // With --exit-code alone, which ends with kDone where everything asked is free.
  kCollision = 10,  // anything asked
  kNotFree = 11,    // none of it, but not everything is known to be free
  kOther = 70,
};

ExitCode ExitCodeOf(const absl::Status& status);

// A mistake on the command line itself: kUsage, whereas bad data in files, on stdin or refused by
// the server is kBadInput.
absl::Status UsageError(const std::string& message);
bool IsUsageError(const absl::Status& status);

}  // namespace cwm::cli
