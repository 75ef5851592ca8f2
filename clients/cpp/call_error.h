// Errors of calls as absl::Status, with all details from the server.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "cwm/error.h"

namespace cwm::client {

// The reason, the fields, the metadata and the time to retry.
using ErrorDetails = api::ErrorInfo;

// The same code and message, with the reply's standard details. They are kept as text, so that
// Status::ToString shows them as a person reads them.
absl::Status StatusFromGrpc(const grpc::Status& status);
absl::Status MakeStatus(absl::StatusCode code, const std::string& message,
                        const ErrorDetails& details);

// The details that these attached; empty for other statuses.
ErrorDetails DetailsOf(const absl::Status& status);

// The same error in both forms. The status must not be OK.
api::Error ErrorFromStatus(const absl::Status& status);
absl::Status StatusFromError(const api::Error& error);

}  // namespace cwm::client
