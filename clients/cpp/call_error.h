// Errors of calls as absl::Status, with all details from the server.
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
  std::string reason;  // UPPER_SNAKE, stable for programs; empty: none given
  std::vector<FieldViolation> fields;
  std::map<std::string, std::string> metadata;
  std::optional<double> retry_after_s;
};

// The same code and message, with the reply's standard details as a payload.
absl::Status StatusFromGrpc(const grpc::Status& status);

// The details that StatusFromGrpc attached; empty for statuses that did not come from a call.
ErrorDetails DetailsOf(const absl::Status& status);

}  // namespace cwm::client
