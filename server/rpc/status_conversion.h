// Converts the application's errors to gRPC: a code, a message, and the standard details under the
// type URLs of google.rpc, so that any client's own classes read them.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "cwm/v1/query.pb.h"

namespace cwm::server {

// ErrorInfo{reason, domain "cwm", metadata} for every error, BadRequest if fields are at fault,
// RetryInfo for overload.
grpc::Status ToGrpcStatus(const absl::Status& status);

// The status's reason; the name of its code if it has none.
std::string ReasonOf(const grpc::Status& status);

// The same for a message of a stream.
v1::QueryError ToQueryError(const absl::Status& status);

// Errors that arise in the transport.
absl::Status Overloaded(std::string message,
                        std::string reason);  // RESOURCE_EXHAUSTED, retry after kRetryAfter_s
absl::Status Draining();                      // UNAVAILABLE SERVER_DRAINING
absl::Status CallCancelled();

}  // namespace cwm::server
