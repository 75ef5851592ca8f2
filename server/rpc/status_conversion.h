// The application's errors as gRPC states them: a code, a message, and the standard details under
// the type URLs of google.rpc, so that any client's own classes read them.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "cwm/v1/query.pb.h"

namespace cwm::server {

// ErrorInfo{reason, domain "cwm", metadata} on every error; BadRequest where fields are at fault;
// RetryInfo on overload.
grpc::Status ToGrpcStatus(const absl::Status& status);

// The reason in it; the name of its code where it has none.
std::string ReasonOf(const grpc::Status& status);

// The same for one message of a stream.
v1::QueryError ToQueryError(const absl::Status& status);

// Errors that the transport itself makes.
absl::Status Overloaded(std::string message,
                        std::string reason);  // RESOURCE_EXHAUSTED, retry after kRetryAfter_s
absl::Status Draining();                      // UNAVAILABLE SERVER_DRAINING
absl::Status CallCancelled();

}  // namespace cwm::server
