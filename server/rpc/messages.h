// Converts messages of our protocol to and from bytes in our own code: so their memory is known
// before they are parsed, large ones can be parsed on a queue, and a malformed request gets an
// explicit error.
#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "server/core/work_budget.h"

namespace cwm::server {

// INVALID_ARGUMENT MALFORMED_REQUEST, naming the method, e.g. "/cwm.v1.WorldService/GetWorld", and
// the type of its requests.
absl::Status MalformedRequest(const std::string& method);

// The method whose request has this type.
std::string MethodWithRequest(const google::protobuf::Descriptor& request);

// Fills `request` and frees the bytes. Drops unknown fields, which take eight times their bytes in
// memory and which nobody reads. INVALID_ARGUMENT MALFORMED_REQUEST, or the status of the budget,
// which is checked throughout. Throws std::bad_alloc.
absl::Status ParseRequest(grpc::ByteBuffer& bytes, google::protobuf::Message* request,
                          WorkBudget* budget);

// INVALID_ARGUMENT REQUEST_TOO_LARGE.
absl::Status CheckStreamRequestSize(const grpc::ByteBuffer& bytes);

// Parses the request of a call that is answered by a stream. The stream keeps its request, so it
// must be small; it names a world and little else. Frees the bytes. The errors of ParseRequest and
// CheckStreamRequestSize.
template <class Request>
absl::Status ParseStreamRequest(const grpc::ByteBuffer* bytes, Request* request) {
  // gRPC lends its own buffer until the call is done.
  grpc::ByteBuffer& lent = *const_cast<grpc::ByteBuffer*>(bytes);
  const absl::Status small = CheckStreamRequestSize(lent);
  WorkBudget unlimited;
  if (small.ok()) return ParseRequest(lent, request, &unlimited);
  lent.Clear();
  return small;
}

// Throws std::bad_alloc.
template <class Response>
grpc::Status SerializeResponse(const Response& response, grpc::ByteBuffer* bytes) {
  bytes->Clear();  // drops the previous message of a stream
  bool owns_bytes = true;
  return grpc::SerializationTraits<Response>::Serialize(response, bytes, &owns_bytes);
}

}  // namespace cwm::server
