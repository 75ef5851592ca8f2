#include "server/core/error.h"

#include <charconv>
#include <cstdint>
#include <string_view>
#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"

namespace cwm::server {
namespace {

// Names our payload within a status; it never leaves the process.
constexpr char kPayload[] = "cwm.server.ErrorDetails";

// The payload is a list of strings, each prefixed by its length: "5:hello". Only this file writes
// and reads it.
class Writer {
 public:
  void Add(std::string_view text) {
    absl::StrAppend(&out_, text.size(), ":");
    out_.append(text);
  }
  void Add(std::size_t number) { Add(std::to_string(number)); }
  std::string Take() { return std::move(out_); }

 private:
  std::string out_;
};

class Reader {
 public:
  explicit Reader(std::string_view in) : in_(in) {}
  std::string Text() {
    std::size_t size = 0;
    const auto [end, error] = std::from_chars(in_.data(), in_.data() + in_.size(), size);
    const std::size_t begin = static_cast<std::size_t>(end - in_.data()) + 1;
    if (error != std::errc() || begin > in_.size() || size > in_.size() - begin) {
      in_ = {};  // not written by us: treated as empty
      return {};
    }
    std::string text(in_.substr(begin, size));
    in_.remove_prefix(begin + size);
    return text;
  }
  std::size_t Number() {
    const std::string text = Text();
    std::size_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
  }

 private:
  std::string_view in_;
};

std::string Encode(const ErrorDetails& details) {
  Writer out;
  out.Add(details.reason);
  out.Add(details.fields.size());
  for (const FieldError& field : details.fields) {
    out.Add(field.field);
    out.Add(field.description);
  }
  out.Add(details.metadata.size());
  for (const auto& [key, value] : details.metadata) {
    out.Add(key);
    out.Add(value);
  }
  out.Add(details.retry_after_s ? std::to_string(*details.retry_after_s) : "");
  return out.Take();
}

ErrorDetails Decode(std::string_view bytes) {
  Reader in(bytes);
  ErrorDetails details;
  details.reason = in.Text();
  for (std::size_t n = in.Number(); n > 0; --n) {
    FieldError field;
    field.field = in.Text();
    field.description = in.Text();
    details.fields.push_back(std::move(field));
  }
  for (std::size_t n = in.Number(); n > 0; --n) {
    std::string key = in.Text();
    details.metadata[std::move(key)] = in.Text();
  }
  if (const std::string retry = in.Text(); !retry.empty()) details.retry_after_s = std::stod(retry);
  return details;
}

}  // namespace

absl::Status MakeError(absl::StatusCode code, std::string message, ErrorDetails details) {
  absl::Status status(code, message);
  status.SetPayload(kPayload, absl::Cord(Encode(details)));
  return status;
}

absl::Status InvalidField(std::string field, std::string description) {
  std::string message = absl::StrCat(field, ": ", description);
  return MakeError(
      absl::StatusCode::kInvalidArgument, std::move(message),
      {.reason = "INVALID_FIELD", .fields = {{std::move(field), std::move(description)}}});
}

absl::Status Overloaded(std::string message, std::string reason, double retry_after_s) {
  return MakeError(
      absl::StatusCode::kResourceExhausted, std::move(message),
      {.reason = std::move(reason), .fields = {}, .metadata = {}, .retry_after_s = retry_after_s});
}

absl::Status ServerDraining() {
  constexpr double kRetryAfter_s = 0.1;
  return MakeError(
      absl::StatusCode::kUnavailable, "the server is shutting down",
      {.reason = "SERVER_DRAINING", .fields = {}, .metadata = {}, .retry_after_s = kRetryAfter_s});
}

ErrorDetails DetailsOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kPayload);
  if (!payload) return {};
  return Decode(std::string(*payload));
}

}  // namespace cwm::server
