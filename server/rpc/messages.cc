#include "server/rpc/messages.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

// Names, uids and tokens of a request take less than a kilobyte.
constexpr std::size_t kMaxStreamRequestBytes = 64 << 10;

}  // namespace

absl::Status CheckStreamRequestSize(const grpc::ByteBuffer& bytes) {
  const std::size_t size = bytes.Length();
  if (size <= kMaxStreamRequestBytes) return absl::OkStatus();
  return MakeError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat("the request has ", size, " bytes, must have at most ", kMaxStreamRequestBytes),
      {.reason = "REQUEST_TOO_LARGE"});
}

absl::Status MalformedRequest(const std::string& method) {
  const std::string name = absl::StrReplaceAll(method.substr(1), {{"/", "."}});
  const auto* known = google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(name);
  const std::string type = known == nullptr ? "" : known->input_type()->full_name();
  return MakeError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat(method, ": the request is no valid ", type, " message"),
      {.reason = "MALFORMED_REQUEST", .metadata = {{"method", method}, {"type", type}}});
}

std::string MethodTaking(const google::protobuf::Descriptor& request) {
  const google::protobuf::FileDescriptor& file = *request.file();
  for (int i = 0; i < file.service_count(); ++i) {
    for (int k = 0; k < file.service(i)->method_count(); ++k) {
      const google::protobuf::MethodDescriptor& method = *file.service(i)->method(k);
      if (method.input_type() == &request) {
        return absl::StrCat("/", file.service(i)->full_name(), "/", method.name());
      }
    }
  }
  return "/" + request.full_name();
}

}  // namespace cwm::server
