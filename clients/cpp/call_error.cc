#include "clients/cpp/call_error.h"

#include <charconv>
#include <cstddef>
#include <map>
#include <optional>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "cwm/v1/error_details.pb.h"

namespace cwm::client {
namespace {

// The keys of the payloads. A field has the key "field 003 box.size_x_m", whose number keeps the
// order, and a name of the metadata "metadata object".
constexpr char kReason[] = "reason";
constexpr char kRetry[] = "retry_after_s";
constexpr char kField[] = "field";
constexpr char kMetadata[] = "metadata";

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

absl::Status MakeStatus(absl::StatusCode code, const std::string& message,
                        const ErrorDetails& details) {
  absl::Status status(code, message);
  if (!details.reason.empty()) status.SetPayload(kReason, absl::Cord(details.reason));
  for (std::size_t i = 0; i < details.fields.size(); ++i) {
    status.SetPayload(absl::StrFormat("%s %03d %s", kField, i, details.fields[i].field),
                      absl::Cord(details.fields[i].description));
  }
  for (const auto& [name, value] : details.metadata) {
    status.SetPayload(absl::StrCat(kMetadata, " ", name), absl::Cord(value));
  }
  if (details.retry_after_s) {
    status.SetPayload(kRetry, absl::Cord(absl::StrCat(*details.retry_after_s)));
  }
  return status;
}

absl::Status StatusFromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  ErrorDetails details;
  cwm::v1::Status packed;
  if (packed.ParseFromString(status.error_details())) {
    for (const auto& any : packed.details()) Add(any, details);
  }
  // absl's codes are the same as gRPC's.
  return MakeStatus(static_cast<absl::StatusCode>(status.error_code()), status.error_message(),
                    details);
}

ErrorDetails DetailsOf(const absl::Status& status) {
  ErrorDetails details;
  std::map<std::string, FieldViolation> fields;  // by their keys, which are visited in any order
  status.ForEachPayload([&](absl::string_view key, const absl::Cord& payload) {
    const std::string text(payload);
    const std::vector<std::string> words = absl::StrSplit(key, absl::MaxSplits(' ', 2));
    if (key == kReason) {
      details.reason = text;
    } else if (key == kRetry) {
      double seconds = 0;
      const auto parsed = std::from_chars(text.data(), text.data() + text.size(), seconds);
      if (parsed.ec == std::errc()) details.retry_after_s = seconds;
    } else if (words[0] == kField && words.size() == 3) {
      fields[std::string(key)] = {words[2], text};
    } else if (words[0] == kMetadata && words.size() > 1) {
      details.metadata[std::string(key.substr(sizeof(kMetadata)))] = text;
    }
  });
  for (auto& [key, field] : fields) details.fields.push_back(std::move(field));
  return details;
}

Error ErrorFromStatus(const absl::Status& status) {
  return Error(static_cast<ErrorCode>(status.code()), std::string(status.message()),
               DetailsOf(status));
}

absl::Status StatusFromError(const Error& error) {
  return MakeStatus(static_cast<absl::StatusCode>(error.code()), error.message(),
                    {.reason = error.reason(),
                     .fields = error.fields(),
                     .metadata = error.metadata(),
                     .retry_after_s = error.retry_after_s()});
}

}  // namespace cwm::client
