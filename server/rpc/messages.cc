#include "server/rpc/messages.h"

#include "absl/strings/str_cat.h"
#include "server/core/error.h"

namespace cwm::server {

std::string MethodTaking(const google::protobuf::Descriptor& request) {
  const google::protobuf::FileDescriptor& file = *request.file();
  for (int i = 0; i < file.service_count(); ++i) {
    for (int k = 0; k < file.service(i)->method_count(); ++k) {
      const google::protobuf::MethodDescriptor& method = *file.service(i)->method(k);
      if (method.input_type() == &request) return method.full_name();
    }
  }
  return request.full_name();
}

absl::Status MalformedRequest(const google::protobuf::Descriptor& request) {
  const std::string method = MethodTaking(request);
  return MakeError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat(method, ": the request is malformed, must be a ", request.full_name()),
      {.reason = "MALFORMED_REQUEST", .fields = {}, .metadata = {{"method", method}}});
}

}  // namespace cwm::server
