#include "clients/cpp/call_error.h"

#include "absl/strings/cord.h"
#include "cwm/v1/error_details.pb.h"

namespace cwm::client {
namespace {

// The type URL under which gRPC packs the details of a status; payload keys are type URLs.
constexpr char kStatusUrl[] = "type.googleapis.com/google.rpc.Status";

// The standard types are read by our own messages with the same field numbers, so only the name in
// the URL is compared.
template <class Message>
std::optional<Message> Unpack(const google::protobuf::Any& any, const std::string& name) {
  const std::string& url = any.type_url();
  if (url.substr(url.rfind('/') + 1) != name) return std::nullopt;
  Message message;
  if (!message.ParseFromString(any.value())) return std::nullopt;
  return message;
}

void Add(const google::protobuf::Any& any, ErrorDetails& details) {
  if (const auto info = Unpack<cwm::v1::ErrorInfo>(any, "google.rpc.ErrorInfo")) {
    details.reason = info->reason();
    details.metadata.insert(info->metadata().begin(), info->metadata().end());
  }
  if (const auto request = Unpack<cwm::v1::BadRequest>(any, "google.rpc.BadRequest")) {
    for (const auto& violation : request->field_violations()) {
      details.fields.push_back({violation.field(), violation.description()});
    }
  }
  if (const auto retry = Unpack<cwm::v1::RetryInfo>(any, "google.rpc.RetryInfo")) {
    details.retry_after_s =
        static_cast<double>(retry->retry_delay().seconds()) + 1e-9 * retry->retry_delay().nanos();
  }
}

}  // namespace

absl::Status StatusFromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  // absl's codes are the same as gRPC's.
  absl::Status error(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
  if (!status.error_details().empty()) {
    error.SetPayload(kStatusUrl, absl::Cord(status.error_details()));
  }
  return error;
}

ErrorDetails DetailsOf(const absl::Status& status) {
  ErrorDetails details;
  const auto payload = status.GetPayload(kStatusUrl);
  cwm::v1::Status packed;
  if (!payload || !packed.ParseFromString(std::string(*payload))) return details;
  for (const auto& any : packed.details()) Add(any, details);
  return details;
}

}  // namespace cwm::client
