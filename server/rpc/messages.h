// Messages of our protocol to and from bytes, in our own hands: their memory is known before they
// are parsed, parsing may happen on a queue, and a malformed request gets an answer that says so.
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

// The method that takes messages of this type.
std::string MethodTaking(const google::protobuf::Descriptor& request);

// Fills `request` and frees the bytes. Drops unknown fields, which take eight times their bytes and
// which nobody looks at. INVALID_ARGUMENT MALFORMED_REQUEST, or the status of the budget, which is
// looked at all along; throws std::bad_alloc.
absl::Status ParseRequest(grpc::ByteBuffer& bytes, google::protobuf::Message* request,
                          WorkBudget* budget);

// INVALID_ARGUMENT REQUEST_TOO_LARGE.
absl::Status CheckStreamRequestSize(const grpc::ByteBuffer& bytes);

// Parses the request of a call that is answered by a stream. The stream keeps its request, which
// names a world and little else, and must be small. Frees the bytes. The errors of ParseRequest and
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
  bytes->Clear();  // of the message before, in a stream
  bool owns_bytes = true;
  return grpc::SerializationTraits<Response>::Serialize(response, bytes, &owns_bytes);
}

}  // namespace cwm::server
