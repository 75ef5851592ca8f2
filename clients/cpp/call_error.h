// Errors of calls, as absl::Status with everything that the server said about them.
#pragma once

#include <grpcpp/support/status.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace cwm::client {

struct FieldViolation {
  std::string field;        // path in the request
  std::string description;  // value and rule
};

struct ErrorDetails {
  std::string reason;  // UPPER_SNAKE, stable for programs; empty: the server gave none
  std::vector<FieldViolation> fields;
  std::map<std::string, std::string> metadata;
  std::optional<double> retry_after_s;
};

// The same code and message; the standard details that the reply carried travel along as a payload.
absl::Status FromGrpc(const grpc::Status& status);

// What FromGrpc found; empty for statuses that did not come from a call.
ErrorDetails DetailsOf(const absl::Status& status);

}  // namespace cwm::client
