#include "server/rpc/status_conversion.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "cwm/v1/error_details.pb.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

constexpr char kDomain[] = "cwm";
constexpr char kTypeUrlPrefix[] = "type.googleapis.com/google.rpc.";
// chosen: a query batch takes milliseconds, an ingest a third of a second; the queues have advanced
// by then.
constexpr double kRetryAfter_s = 0.1;

std::string Text(const absl::Status& status) { return std::string(status.message()); }

// The status's reason, or the name of its code if it has none, so that programs always find one.
std::string ReasonOf(const absl::Status& status, const ErrorDetails& details) {
  if (!details.reason.empty()) return details.reason;
  return absl::StatusCodeToString(status.code());
}

void AddDetail(const google::protobuf::Message& detail, const char* name, v1::Status* status) {
  google::protobuf::Any* any = status->add_details();
  any->set_type_url(std::string(kTypeUrlPrefix) + name);
  any->set_value(detail.SerializeAsString());
}

v1::ErrorInfo InfoOf(const absl::Status& status, const ErrorDetails& details) {
  v1::ErrorInfo info;
  info.set_reason(ReasonOf(status, details));
  info.set_domain(kDomain);
  info.mutable_metadata()->insert(details.metadata.begin(), details.metadata.end());
  return info;
}

v1::BadRequest BadRequestOf(const ErrorDetails& details) {
  v1::BadRequest bad_request;
  for (const FieldError& field : details.fields) {
    v1::BadRequest::FieldViolation* violation = bad_request.add_field_violations();
    violation->set_field(field.field);
    violation->set_description(field.description);
  }
  return bad_request;
}

google::protobuf::Duration DurationOf(double seconds) {
  const double whole = std::floor(seconds);
  google::protobuf::Duration duration;
  duration.set_seconds(static_cast<std::int64_t>(whole));
  duration.set_nanos(static_cast<std::int32_t>((seconds - whole) * 1e9));
  return duration;
}

v1::RetryInfo RetryOf(double retry_after_s) {
  v1::RetryInfo retry;
  *retry.mutable_retry_delay() = DurationOf(retry_after_s);
  return retry;
}

}  // namespace

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const ErrorDetails details = DetailsOf(status);
  v1::Status packed;
  packed.set_code(static_cast<int>(status.code()));
  packed.set_message(Text(status));
  AddDetail(InfoOf(status, details), "ErrorInfo", &packed);
  if (!details.fields.empty()) AddDetail(BadRequestOf(details), "BadRequest", &packed);
  if (details.retry_after_s) AddDetail(RetryOf(*details.retry_after_s), "RetryInfo", &packed);
  // absl's canonical codes are the same as gRPC's.
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), Text(status),
                      packed.SerializeAsString());
}

std::string ReasonOf(const grpc::Status& status) {
  v1::Status packed;
  v1::ErrorInfo info;
  if (packed.ParseFromString(status.error_details())) {
    for (const google::protobuf::Any& detail : packed.details()) {
      if (detail.type_url() != absl::StrCat(kTypeUrlPrefix, "ErrorInfo")) continue;
      if (info.ParseFromString(detail.value())) return info.reason();
    }
  }
  return absl::StatusCodeToString(static_cast<absl::StatusCode>(status.error_code()));
}

v1::QueryError ToQueryError(const absl::Status& status) {
  const ErrorDetails details = DetailsOf(status);
  v1::QueryError error;
  error.set_code(static_cast<int>(status.code()));
  error.set_message(Text(status));
  error.set_reason(ReasonOf(status, details));
  for (const FieldError& field : details.fields) {
    v1::FieldError* added = error.add_fields();
    added->set_field(field.field);
    added->set_description(field.description);
  }
  error.mutable_metadata()->insert(details.metadata.begin(), details.metadata.end());
  if (details.retry_after_s) *error.mutable_retry_delay() = DurationOf(*details.retry_after_s);
  return error;
}

absl::Status Overloaded(std::string message, std::string reason) {
  return Overloaded(std::move(message), std::move(reason), kRetryAfter_s);
}

absl::Status Draining() { return ServerDraining(); }

absl::Status CallCancelled() {
  return MakeError(absl::StatusCode::kCancelled, "the call was cancelled",
                   {.reason = "CANCELLED", .fields = {}, .metadata = {}, .retry_after_s = {}});
}

}  // namespace cwm::server
