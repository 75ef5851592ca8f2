#include "clients/cpp/query_stream.h"

#include "absl/strings/str_cat.h"

namespace cwm::client {
namespace {

// The same status that a unary call returns.
absl::Status FromError(const v1::QueryError& error) {
  std::string message = error.message();
  for (const v1::FieldError& field : error.fields()) {
    const std::string line = absl::StrCat(field.field(), ": ", field.description());
    if (line != message) absl::StrAppend(&message, "; ", line);
  }
  if (!error.reason().empty()) absl::StrAppend(&message, " (", error.reason(), ")");
  return absl::Status(static_cast<absl::StatusCode>(error.code()), message);
}

}  // namespace

QueryStream::QueryStream(const Connection& connection)
    : stream_(connection.queries().StreamQueries(&context_)) {}

QueryStream::~QueryStream() {
  if (stream_ == nullptr) return;
  stream_->WritesDone();
  v1::StreamQueriesResponse ignored;
  while (stream_->Read(&ignored)) {
  }
  // The query that failed has already returned the error.
  static_cast<void>(stream_->Finish());
}

absl::StatusOr<v1::StreamQueriesResponse> QueryStream::Evaluate(v1::StreamQueriesRequest& request) {
  if (stream_ == nullptr) return absl::UnavailableError("the server ended the stream");
  request.set_id(++id_);
  v1::StreamQueriesResponse response;
  if (!stream_->Write(request) || !stream_->Read(&response)) return EndOfStream();
  if (response.has_error()) return FromError(response.error());
  return response;
}

absl::Status QueryStream::EndOfStream() {
  absl::Status status = StatusFromGrpc(stream_->Finish());
  stream_.reset();
  return status.ok() ? absl::UnavailableError("the server ended the stream") : status;
}

}  // namespace cwm::client
