// Errors of the application: an absl::Status with a machine-readable reason, the fields at fault
// and metadata, carried as payloads so that they survive every layer. server/rpc converts them to
// the standard details.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace cwm::server {

struct FieldError {
  std::string field;  // path in the request, e.g. "changes[2].put.object.shapes[0].box.size_x_m"
  std::string description;  // value and rule, e.g. "is -0.1, must be positive and finite"
  friend bool operator==(const FieldError&, const FieldError&) = default;
};

struct ErrorDetails {
  std::string reason;  // UPPER_SNAKE, e.g. "REVISION_MISMATCH", stable for programs
  std::vector<FieldError> fields = {};
  std::map<std::string, std::string> metadata = {};
  std::optional<double> retry_after_s = {};  // set for overload
};

absl::Status MakeError(absl::StatusCode code, std::string message, ErrorDetails details);
// INVALID_ARGUMENT INVALID_FIELD; the message is "field: description".
absl::Status InvalidField(std::string field, std::string description);
// RESOURCE_EXHAUSTED with the time after which a retry may succeed.
absl::Status Overloaded(std::string message, std::string reason, double retry_after_s);
// UNAVAILABLE SERVER_DRAINING, with the time after which a successor may answer.
absl::Status ServerDraining();
// The details of a status; the reason is empty if the status has none.
ErrorDetails DetailsOf(const absl::Status& status);

}  // namespace cwm::server
